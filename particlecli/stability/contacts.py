"""The modes of soft spheres that touch, whether or not any do when they are born."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.masses import masses
from particlecli.scene.forces import SoftSphere
from particlecli.stability.modes import Modes

PACKED = 8.0
"""Eigenvalue of L = Σ n nᵀ over the contacts of a close packing: spheres that move against all of their 12 neighbours.
Of as many contacts in all directions a sphere feels 12/3 along each, and as much again by the neighbours' motion."""


def contact_modes(force: SoftSphere, groups: Sequence[GroupPlan]) -> Modes:
    """The two fastest modes in a close packing of the lightest spheres: α² + α c d/m + c k/m = 0, c = `PACKED`.

    Args:
        force: of stiffness k, N/m, and damping d, kg/s.
        groups: that it acts on; together they have a particle at least.
    """
    lightest = min(float(masses(group, np.arange(group.births.total)).min()) for group in groups if group.births.total)
    rates = np.roots([1.0, PACKED * force.damping / lightest, PACKED * force.stiffness / lightest])
    return Modes.of_pairs(rates.astype(complex))

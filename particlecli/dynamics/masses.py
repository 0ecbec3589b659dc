"""Masses of the particles of a group."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.group_plan import Constant, GroupPlan


def masses(plan: GroupPlan, ids: NDArray[np.int64]) -> NDArray[np.float64]:
    """Masses of particles of a group, kg, shape (n,)."""
    differing = plan.births.of(ids).masses
    return np.full(len(ids), 1.0 / plan.constants[Constant.INVERSE_MASS]) if differing is None else differing

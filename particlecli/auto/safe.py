"""Steps that are short enough for a scheme to stay stable, where the scene itself tells its fastest oscillation."""

from __future__ import annotations

import math

import numpy as np

from particlecli.dynamics.integrators.base import AdaptiveRungeKutta, AnyScheme, ClosedForm
from particlecli.dynamics.plan import Plan
from particlecli.scene.forces import SoftSphere, Springs
from particlecli.scene.model import Scene
from particlecli.stability.contacts import contact_modes
from particlecli.stability.growth import stability_limit
from particlecli.stability.modes import Modes

MARGIN = 0.85
"""Part of the longest stable step that is safe: what is bent and stretched oscillates faster than what is at rest, and
near the limit errors fade or grow so slowly that a pilot of a few frames does not see it."""


class SafeSteps:
    """The longest safe steps in a plan's coupled groups, by the modes of springs at birth and of spheres that touch."""

    def __init__(self, plan: Plan) -> None:
        self._modes = Modes.of_pairs(np.empty(0, complex))
        groups = {group.name: group for group in plan.groups if group.coupled}
        for each in plan.couplings:
            if isinstance(each.force, SoftSphere):
                touching = contact_modes(each.force, [groups[name] for name in each.groups])
                self._modes = self._modes.joined(touching)
        if any(isinstance(each.force, Springs) for each in plan.couplings):
            from particlecli.stability.springs import fastest_modes  # brings SciPy, which other scenes do without

            for group in groups.values():
                self._modes = self._modes.joined(fastest_modes(group, plan.couplings))

    def fewest(self, scheme: AnyScheme, scene: Scene) -> int:
        """Steps in a frame of the longest step that is safe and that the scene allows."""
        longest = min(scene.integrator.dt or math.inf, self.longest(scheme))
        return max(1, math.ceil(1.0 / scene.fps / longest * (1.0 - 1e-9)))

    def longest(self, scheme: AnyScheme) -> float:
        """The longest, s; infinite where nothing is known to limit it, and for a scheme that finds its own."""
        if isinstance(scheme, AdaptiveRungeKutta | ClosedForm):
            return math.inf
        return MARGIN * stability_limit(scheme, self._modes)[0]

"""Steps that are short enough for a scheme to stay stable, where the scene itself tells its fastest oscillation."""

from __future__ import annotations

import math
from functools import reduce

import numpy as np

from particlecli.dynamics.integrators.base import AdaptiveRungeKutta, AnyScheme, ClosedForm
from particlecli.dynamics.plan import Plan
from particlecli.scene.forces import Springs
from particlecli.stability.growth import stability_limit
from particlecli.stability.modes import Modes

MARGIN = 0.85
"""Part of the longest stable step that is safe: what is bent and stretched oscillates faster than what is at rest, and
near the limit errors fade so slowly, or grow so slowly, that a pilot of a few frames does not see it."""


class SafeSteps:
    """The longest safe steps in a plan's coupled groups, by the modes of their springs at birth."""

    def __init__(self, plan: Plan) -> None:
        self._modes = Modes.of_pairs(np.empty(0, complex))
        groups = [group for group in plan.groups if group.coupled]
        if any(isinstance(each.force, Springs) for each in plan.couplings):
            from particlecli.stability.springs import fastest_modes  # brings SciPy, which other scenes do without

            self._modes = reduce(Modes.joined, (fastest_modes(group, plan.couplings) for group in groups), self._modes)

    def longest(self, scheme: AnyScheme) -> float:
        """The longest, s; infinite where nothing is known to limit it, and for a scheme that finds its own."""
        if isinstance(scheme, AdaptiveRungeKutta | ClosedForm):
            return math.inf
        return MARGIN * stability_limit(scheme, self._modes)[0]

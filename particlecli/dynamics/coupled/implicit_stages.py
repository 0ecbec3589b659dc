"""Stages of implicit Runge–Kutta steps of coupled particles, solved for one after the other."""

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.coupled.slopes import Slopes
from particlecli.dynamics.integrators.base import ImplicitRungeKutta


@ti.data_oriented
class ImplicitStages(Slopes):
    """Stages from the accelerations alone, as of `RungeKuttaStages`; a stage may depend on its own, not on later ones.

    Attributes:
        times, repeats: as of `RungeKuttaStages`.
        explicit: how many stages at the beginning need no solving.
        own_weights: a of each stage on itself.
    """

    repeats = False

    def __init__(self, scheme: ImplicitRungeKutta, points: Points) -> None:
        super().__init__(points, len(scheme.b))
        self.times = list(scheme.c)
        self.stages = len(scheme.b)
        self.explicit = scheme.explicit_stages
        self.own_weights = [row[i] for i, row in enumerate(scheme.a)]
        a = np.array([*scheme.a, scheme.b])
        table = np.column_stack([[*scheme.c, 1.0], a @ np.array(scheme.a), a])
        self.table = points.memory.table(points.real, table)

    @ti.func
    def approach(self, row, b, h):
        """On to a stage, or to the end of the step after the last; h is the length of the step, s, a pack."""
        for c in ti.static(range(3)):
            x, v = 0.0 * h, 0.0 * h
            for j in range(ti.min(row + 1, self.stages)):
                slope = self.slopes[3 * j + c, b]
                x, v = x + self.table[row, 1 + j] * slope, v + self.table[row, 1 + self.stages + j] * slope
            self.points.state[c, b] = self.base[c, b] + h * (self.table[row, 0] * self.base[c + 3, b] + h * x)
            self.points.state[c + 3, b] = self.base[c + 3, b] + h * v

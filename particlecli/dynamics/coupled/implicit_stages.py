"""Stages of implicit Runge–Kutta steps of coupled particles, solved for one after the other."""

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.group_plan import LANES
from particlecli.dynamics.integrators.base import ImplicitRungeKutta


@ti.data_oriented
class ImplicitStages:
    """Stages from the accelerations alone, as of `RungeKuttaStages`; a stage may depend on its own, not on later ones.

    Attributes:
        times, repeats, base: as of `RungeKuttaStages`.
        explicit: how many stages at the beginning need no solving.
        own_weights: a of each stage on itself.
        slopes: field of packs, shape (3 stages, packs): the accelerations.
    """

    repeats = False

    def __init__(self, scheme: ImplicitRungeKutta, points: Points) -> None:
        self.points = points
        self.times = list(scheme.c)
        self.stages = len(scheme.b)
        self.explicit = scheme.explicit_stages
        self.own_weights = [row[i] for i, row in enumerate(scheme.a)]
        a = np.array([*scheme.a, scheme.b])
        table = np.column_stack([[*scheme.c, 1.0], a @ np.array(scheme.a), a])
        self.table = points.memory.table(points.real, table)
        pack = ti.types.vector(LANES, points.real)
        self.base = ti.field(pack, shape=(6, points.capacity))
        self.slopes = ti.field(pack, shape=(3 * self.stages, points.capacity))

    @ti.func
    def begin(self, b):
        """Remember where a step begins."""
        for c in ti.static(range(6)):
            self.base[c, b] = self.points.state[c, b]

    @ti.func
    def keep(self, i, b, a):
        """Keep the accelerations, three packs, of evaluation i."""
        for c in ti.static(range(3)):
            self.slopes[3 * i + c, b] = a[c]

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

"""Where a step of coupled particles begins, and the accelerations found in it so far."""

import taichi as ti

from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.group_plan import LANES


@ti.data_oriented
class Slopes:
    """What stages of a step keep of packs.

    Args:
        points: the particles.
        count: how many evaluations are kept.

    Attributes:
        base: field of packs, shape (6, packs): the state at the beginning of the step.
        slopes: field of packs, shape (3 count, packs): accelerations, m/s², evaluation by evaluation.
    """

    def __init__(self, points: Points, count: int) -> None:
        self.points = points
        pack = ti.types.vector(LANES, points.real)
        self.base = ti.field(pack, shape=(6, points.capacity))
        self.slopes = ti.field(pack, shape=(3 * count, points.capacity))

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

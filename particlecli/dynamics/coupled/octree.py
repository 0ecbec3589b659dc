"""An octree over bodies, which it puts in Morton order."""

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli.dynamics.coupled.octree_cells import INTEGERS, KEYS, LEVELS, REALS, Cells, grow
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.group_plan import LANES


@ti.func
def spread(q):
    """The bits of a whole number below 2²¹, two zeros after each."""
    x = ti.cast(q, ti.i64)
    x = (x | (x << 32)) & ti.i64(0x1F00000000FFFF)
    x = (x | (x << 16)) & ti.i64(0x1F0000FF0000FF)
    x = (x | (x << 8)) & ti.i64(0x100F00F00F00F00F)
    x = (x | (x << 4)) & ti.i64(0x10C30C30C30C30C3)
    return (x | (x << 2)) & ti.i64(0x1249249249249249)


@ti.kernel
def morton_keys(positions: REALS, low: ti.types.vector(3, ti.f64), size: ti.f64, keys: KEYS):
    """The place of positions, m, along the Morton curve through a cube of a corner and size, m."""
    for i in range(keys.shape[0]):
        key = ti.cast(0, ti.i64)
        for c in ti.static(range(3)):
            share = (positions[i, c] - low[c]) / size * 2**LEVELS
            key = key | (spread(ti.min(ti.max(ti.cast(share, ti.i32), 0), 2**LEVELS - 1)) << (2 - c))
        keys[i] = key


@ti.data_oriented
class Octree:
    """Bodies in Morton order, and the cells over them.

    Args:
        points: all coupled particles.
        groups: places of the groups that matter.
        angle: cells act as a whole where they look smaller than this, radians.

    Attributes:
        bodies: field of 4-vectors: position, m, and mass, kg.
        order: field of i32: each body's number among the points.
        count: bodies.
        cells, cell_count: the cells.
        width: bodies in a pack of targets.
    """

    def __init__(self, points: Points, groups: tuple[int, ...], angle: float) -> None:
        self.points = points
        self.groups = groups
        self.angle = angle
        self.width = 8 if points.real == ti.f64 else 16
        slots = points.capacity * LANES
        self.bodies = ti.field(ti.types.vector(4, points.real), shape=slots)
        self.order = ti.field(ti.i32, shape=slots)
        self.cells = Cells(max(64, slots // 4), points.real)
        self.count = self.cell_count = 0

    def build(self) -> None:
        """Put the present stage of the points into order and make the tree anew."""
        slots = self.points.capacity * LANES
        positions, acts = np.zeros((slots, 3)), np.zeros(slots, np.int32)
        self._collect(positions, acts)
        places = np.flatnonzero(acts).astype(np.int32)
        self.count = len(places)
        if not self.count:
            return
        chosen = positions[places]
        low, high = chosen.min(axis=0), chosen.max(axis=0)
        size = float((high - low).max()) * (1 + 1e-6) or 1.0
        keys = np.empty(self.count, np.int64)
        morton_keys(chosen, ti.Vector(low), size, keys)
        order = np.argsort(keys, kind="stable")
        self._take(places[order])
        cells = self._grown(keys[order])
        moments = np.empty((self.cell_count, 10))
        self.cells.weigh(self.bodies, self.cell_count, cells, moments, size, self.angle)

    def _grown(self, keys: NDArray[np.int64]) -> NDArray[np.int32]:
        stack, begins = np.empty((8 * LEVELS + 8, 3), np.int32), np.zeros(self.count + 1, np.int32)
        while True:
            cells = np.empty((self.cells.room, 6), np.int32)
            self.cell_count = int(grow(keys, stack, cells, begins))
            if self.cell_count <= self.cells.room:
                return cells
            self.cells = Cells(self.cell_count + self.cell_count // 4, self.points.real)

    @ti.kernel
    def _collect(self, positions: REALS, acts: INTEGERS):
        for g in ti.static(self.groups):
            for b in range(self.points.firsts[g], self.points.firsts[g + 1]):
                for lane in range(LANES):
                    slot = b * LANES + lane
                    acts[slot] = self.points.mass[b][lane] > 0
                    for c in ti.static(range(3)):
                        positions[slot, c] = ti.cast(self.points.state[c, b][lane], ti.f64)

    @ti.kernel
    def _take(self, order: INTEGERS):
        for i in range(order.shape[0]):
            b, lane = order[i] // LANES, order[i] % LANES
            self.order[i] = order[i]
            for c in ti.static(range(3)):
                self.bodies[i][c] = self.points.state[c, b][lane]
            self.bodies[i][3] = self.points.mass[b][lane]

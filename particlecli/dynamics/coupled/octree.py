"""An octree over bodies in Morton order, laid out depth first, with the moments of its cells."""

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.group_plan import LANES

LEAF = 16
"""Most bodies in a leaf, unless they are so close that their keys are the same."""

LEVELS = 21
"""Levels of cells that a key of 63 bits tells apart."""

INTEGERS = ti.types.ndarray(dtype=ti.i32, ndim=1)
KEYS = ti.types.ndarray(dtype=ti.i64, ndim=1)
REALS = ti.types.ndarray(dtype=ti.f64, ndim=2)


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


@ti.kernel
def grow(
    keys: KEYS,
    stack: ti.types.ndarray(dtype=ti.i32, ndim=2),
    cells: ti.types.ndarray(dtype=ti.i32, ndim=2),
    begins: INTEGERS,
) -> ti.i32:
    """Make cells depth first; cells without a choice between children are left out.

    Args:
        keys: in ascending order.
        stack: room for what is to be done.
        cells: filled: first and last body (exclusive), level, parent, cell after all below it, whether it is a leaf.
        begins: one longer than keys, for the search of the cell that begins at a body.

    Returns:
        How many cells there are; where that is more than there is room for, they are incomplete.
    """
    count = 0
    ti.loop_config(serialize=True)
    for _ in range(1):
        stack[0, 0], stack[0, 1], stack[0, 2] = 0, keys.shape[0], -1
        top = 1
        while top > 0:
            top -= 1
            first, last, parent = stack[top, 0], stack[top, 1], stack[top, 2]
            differing = keys[first] ^ keys[last - 1]
            level = 0
            while (level < LEVELS) & ((differing >> (3 * (LEVELS - 1 - level))) == 0):
                level += 1
            leaf = (last - first <= LEAF) | (level == LEVELS)
            if count < cells.shape[0]:
                cells[count, 0], cells[count, 1], cells[count, 2] = first, last, level
                cells[count, 3], cells[count, 5] = parent, ti.select(leaf, 1, 0)
            if not leaf:
                shift = 3 * (LEVELS - 1 - level)
                end = last
                # The last child goes first onto the stack, so that the first comes off first.
                for n in range(8):
                    begin = first_of_child(keys, first, end, shift, 7 - n)
                    if begin < end:
                        stack[top, 0], stack[top, 1], stack[top, 2] = begin, end, count
                        top += 1
                    end = begin
            count += 1
        begins[keys.shape[0]] = count
        for k in range(ti.min(count, cells.shape[0])):
            n = ti.min(count, cells.shape[0]) - 1 - k
            cells[n, 4] = begins[cells[n, 1]]
            begins[cells[n, 0]] = n
    return count


@ti.func
def first_of_child(keys: ti.template(), first, last, shift, child):
    """The first body, from `first` on and before `last`, whose digit is at least that of a child."""
    low, high = first, last
    while low < high:
        middle = (low + high) // 2
        if (keys[middle] >> shift) & 7 < child:
            low = middle + 1
        else:
            high = middle
    return low


@ti.data_oriented
class Cells:
    """What a walk through the tree reads.

    Attributes:
        room: cells there is room for.
        center: field of 4-vectors: centre of mass, m, and mass, kg.
        spread: field of 6-vectors: Σ m δ_i δ_j about it for xx, xy, xz, yy, yz, zz, kg m².
        reach2: field: from this squared distance on, m², a cell acts as a whole.
        span: field of 4-vectors of i32: first body, last one (exclusive), the cell after all below it, leaf or not.
    """

    def __init__(self, room: int, real) -> None:
        self.room = room
        self.real = real
        self.center = ti.field(ti.types.vector(4, real), shape=room)
        self.spread = ti.field(ti.types.vector(6, real), shape=room)
        self.reach2 = ti.field(real, shape=room)
        self.span = ti.field(ti.types.vector(4, ti.i32), shape=room)

    @ti.kernel
    def weigh(
        self,
        bodies: ti.template(),
        count: ti.i32,
        cells: ti.types.ndarray(dtype=ti.i32, ndim=2),
        moments: REALS,
        size: ti.f64,
        angle: ti.f64,
    ):
        """Moments of the cells, from the leaves up.

        Args:
            bodies: field of 4-vectors: position, m, and mass, kg, in the order of keys.
            count: cells.
            cells: from `grow`.
            moments: room for ten numbers a cell: mass, mass times position, spread.
            size: of the cube that keys are made for, m.
            angle: cells act as a whole where they look smaller.
        """
        for n in range(count):
            for k in ti.static(range(10)):
                moments[n, k] = 0.0
            if cells[n, 5] == 1:
                for j in range(cells[n, 0], cells[n, 1]):
                    mass = ti.cast(bodies[j][3], ti.f64)
                    moments[n, 0] = moments[n, 0] + mass
                    for c in ti.static(range(3)):
                        moments[n, 1 + c] = moments[n, 1 + c] + mass * bodies[j][c]
        ti.loop_config(serialize=True)
        for k in range(count - 1):
            n = count - 1 - k
            for c in ti.static(range(4)):
                moments[cells[n, 3], c] = moments[cells[n, 3], c] + moments[n, c]
        for n in range(count):
            if cells[n, 5] == 1:
                for j in range(cells[n, 0], cells[n, 1]):
                    mass, at = ti.cast(bodies[j][3], ti.f64), bodies[j]
                    self._add_spread(moments, n, mass, ti.Vector([at[0], at[1], at[2]]))
        ti.loop_config(serialize=True)
        for k in range(count - 1):
            n = count - 1 - k
            parent = cells[n, 3]
            for c in ti.static(range(4, 10)):
                moments[parent, c] = moments[parent, c] + moments[n, c]
            self._add_spread(moments, parent, moments[n, 0], self._center(moments, n))
        for n in range(count):
            center = self._center(moments, n)
            side = size / ti.cast(1 << cells[n, 2], ti.f64)
            # Never a cell that a target is in: its centre of mass is nearer than the cell's diagonal.
            self.reach2[n] = ti.cast((side * ti.max(1.0 / angle, ti.sqrt(3.0))) ** 2, self.real)
            self.center[n] = ti.cast(ti.Vector([center[0], center[1], center[2], moments[n, 0]]), self.real)
            for c in ti.static(range(6)):
                self.spread[n][c] = ti.cast(moments[n, 4 + c], self.real)
            self.span[n] = ti.Vector([cells[n, 0], cells[n, 1], cells[n, 4], cells[n, 5]])

    @ti.func
    def _center(self, moments: ti.template(), n):
        mass = moments[n, 0]
        return ti.Vector([moments[n, 1] / mass, moments[n, 2] / mass, moments[n, 3] / mass])

    @ti.func
    def _add_spread(self, moments: ti.template(), n, mass, position):
        d = position - self._center(moments, n)
        place = 4
        for i in ti.static(range(3)):
            for j in ti.static(range(i, 3)):
                moments[n, place] = moments[n, place] + mass * d[i] * d[j]
                place += 1


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

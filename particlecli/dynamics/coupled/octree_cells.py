"""Cells of an octree over bodies in Morton order, laid out depth first, and their moments."""

import taichi as ti

LEAF = 16
"""Most bodies in a leaf, unless they are so close that their keys are the same."""

LEVELS = 21
"""Levels of cells that a key of 63 bits tells apart."""

FIRST, LAST, LEVEL, PARENT, NEXT, IS_LEAF = range(6)
"""Columns of cells: first and last body (exclusive), level, parent, the cell after all below it, whether a leaf."""

INTEGERS = ti.types.ndarray(dtype=ti.i32, ndim=1)
KEYS = ti.types.ndarray(dtype=ti.i64, ndim=1)
TABLE = ti.types.ndarray(dtype=ti.i32, ndim=2)
REALS = ti.types.ndarray(dtype=ti.f64, ndim=2)


@ti.kernel
def grow(keys: KEYS, stack: TABLE, cells: TABLE, begins: INTEGERS) -> ti.i32:
    """Make cells depth first; cells without a choice between children are left out.

    Args:
        keys: in ascending order.
        stack: room for what is to be done.
        cells: filled, see `FIRST` and so on.
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
                cells[count, FIRST], cells[count, LAST], cells[count, LEVEL] = first, last, level
                cells[count, PARENT], cells[count, IS_LEAF] = parent, ti.select(leaf, 1, 0)
            if not leaf:
                top = _put_children(keys, first, last, level, count, stack, top)
            count += 1
        begins[keys.shape[0]] = count
        for k in range(ti.min(count, cells.shape[0])):
            n = ti.min(count, cells.shape[0]) - 1 - k
            cells[n, NEXT] = begins[cells[n, LAST]]
            begins[cells[n, FIRST]] = n
    return count


@ti.func
def _put_children(keys: ti.template(), first, last, level, parent, stack: ti.template(), top):
    """Put the children of a cell onto a stack of this height, the first one last; returns the height then."""
    shift = 3 * (LEVELS - 1 - level)
    end, height = last, top
    for n in range(8):
        begin = _first_of_child(keys, first, end, shift, 7 - n)
        if begin < end:
            stack[height, 0], stack[height, 1], stack[height, 2] = begin, end, parent
            height += 1
        end = begin
    return height


@ti.func
def _first_of_child(keys: ti.template(), first, last, shift, child):
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
    def weigh(self, bodies: ti.template(), count: ti.i32, cells: TABLE, moments: REALS, size: ti.f64, angle: ti.f64):
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
            if cells[n, IS_LEAF] == 1:
                for j in range(cells[n, FIRST], cells[n, LAST]):
                    mass = ti.cast(bodies[j][3], ti.f64)
                    moments[n, 0] = moments[n, 0] + mass
                    for c in ti.static(range(3)):
                        moments[n, 1 + c] = moments[n, 1 + c] + mass * bodies[j][c]
        ti.loop_config(serialize=True)
        for k in range(count - 1):
            n = count - 1 - k
            for c in ti.static(range(4)):
                moments[cells[n, PARENT], c] = moments[cells[n, PARENT], c] + moments[n, c]
        for n in range(count):
            if cells[n, IS_LEAF] == 1:
                for j in range(cells[n, FIRST], cells[n, LAST]):
                    mass, at = ti.cast(bodies[j][3], ti.f64), bodies[j]
                    self._add_spread(moments, n, mass, ti.Vector([at[0], at[1], at[2]]))
        ti.loop_config(serialize=True)
        for k in range(count - 1):
            n = count - 1 - k
            parent = cells[n, PARENT]
            for c in ti.static(range(4, 10)):
                moments[parent, c] = moments[parent, c] + moments[n, c]
            self._add_spread(moments, parent, moments[n, 0], self._center(moments, n))
        for n in range(count):
            center = self._center(moments, n)
            side = size / ti.cast(1 << cells[n, LEVEL], ti.f64)
            # Never a cell that a target is in: its centre of mass is nearer than the cell's diagonal.
            self.reach2[n] = ti.cast((side * ti.max(1.0 / angle, ti.sqrt(3.0))) ** 2, self.real)
            self.center[n] = ti.cast(ti.Vector([center[0], center[1], center[2], moments[n, 0]]), self.real)
            for c in ti.static(range(6)):
                self.spread[n][c] = ti.cast(moments[n, 4 + c], self.real)
            self.span[n] = ti.Vector([cells[n, FIRST], cells[n, LAST], cells[n, NEXT], cells[n, IS_LEAF]])

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

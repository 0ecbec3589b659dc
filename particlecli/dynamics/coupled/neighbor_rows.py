"""Rows: particles sorted so that neighbours stand together, followed by images of those near walls and faces."""

from copy import copy

import taichi as ti

from particlecli.dynamics.coupled.neighbor_grid import INTEGERS
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.coupled.sharing import WORKERS
from particlecli.dynamics.group_plan import LANES

REALS = ti.types.ndarray(dtype=ti.f64, ndim=2)


@ti.data_oriented
class Rows:
    """What local forces read: a row for each acting particle in the order of the grid, then a row for each image.

    Attributes:
        at: field of 4-vectors, a row each: x, y, z, m, and mass, kg.
        moving: field of 4-vectors: u, v, w, m/s, and one quantity more that a force may keep; only where asked for.
        order: field of i32: the particle's number among the points.
        place: field of packs of i32: the row of each of the points, −1 where there is none.
        width: particles in a pack of targets: one register's worth.
        room: rows there are, images included.
        axes: in how many of x, y, z particles can be apart: 2 for a sheet in the x–y plane.
        counter: for sharing packs out among threads.
        sums: field of packs, shape (workers, 4): for `over_neighbors`.
    """

    def __init__(self, points: Points, room: int, moves: bool, axes: int = 3) -> None:
        self.points = points
        self.moves = moves
        self.axes = axes
        self.real = points.real
        self.width = 4 if points.real == ti.f64 else 8
        self.counter = ti.field(ti.i32, shape=1)
        self.sums = ti.field(ti.types.vector(self.width, points.real), shape=(WORKERS, 4))
        self.order = ti.field(ti.i32, shape=points.capacity * LANES)
        self.place = ti.field(ti.types.vector(LANES, ti.i32), shape=points.capacity)
        self.origin = ti.field(ti.types.vector(LANES, points.real), shape=(3, points.capacity))
        self.folded = ti.field(ti.types.vector(LANES, points.real), shape=(3, points.capacity))
        self.changed = ti.field(ti.i32, shape=())
        self._take(room)

    def enlarged(self, room: int) -> "Rows":
        """The same with room for so many rows; those are to be filled anew."""
        other = copy(self)
        other._take(room)
        return other

    def _take(self, room: int) -> None:
        row = ti.types.vector(4, self.points.real)
        self.room = room
        self.at = ti.field(row, shape=room)
        self.moving = ti.field(row, shape=room if self.moves else 1)

    @ti.kernel
    def collect(
        self,
        groups: ti.template(),
        low: ti.types.vector(3, ti.f64),
        size: ti.types.vector(3, ti.f64),
        positions: REALS,
        acts: INTEGERS,
    ):
        """Positions of all points, m, folded into a box along axes in which it has a size, and whether they act."""
        for b in range(self.points.capacity):
            for k in ti.static(range(3)):
                self.folded[k, b] = 0.0 * self.folded[k, b]
            for lane in range(LANES):
                acts[b * LANES + lane] = 0
        for g in ti.static(groups):
            for b in range(self.points.firsts[g], self.points.firsts[g + 1]):
                for lane in range(LANES):
                    slot = b * LANES + lane
                    acts[slot] = self.points.mass[b][lane] > 0
                    for k in ti.static(range(3)):
                        x = self.points.state[k, b][lane]
                        if size[k] > 0:
                            turns = ti.floor((ti.cast(x, ti.f64) - low[k]) / size[k])
                            self.folded[k, b][lane] = ti.cast(turns * size[k], self.real)
                            x = x - self.folded[k, b][lane]
                        positions[k, slot] = ti.cast(x, ti.f64)

    @ti.kernel
    def settle(self, order: INTEGERS, rows: ti.i32):
        """Take the particles into rows in this order."""
        for b in range(self.points.capacity):
            self.place[b] = ti.Vector([-1] * LANES)
            for k in ti.static(range(3)):
                self.origin[k, b] = self.points.state[k, b]
        for row in range(rows):
            slot = order[row]
            self.order[row] = slot
            self.place[slot // LANES][slot % LANES] = row

    @ti.kernel
    def refresh(self, groups: ti.template(), limit: ti.f64) -> ti.i32:
        """Copy the present stage into the rows.

        Returns:
            Whether a particle went further than `limit`, m, from where it was when settled, or came or went.
        """
        self.changed[None] = 0
        for g in ti.static(groups):
            for b in range(self.points.firsts[g], self.points.firsts[g + 1]):
                x, y, z = self.points.state[0, b], self.points.state[1, b], self.points.state[2, b]
                dx, dy, dz = x - self.origin[0, b], y - self.origin[1, b], z - self.origin[2, b]
                mass, place = self.points.mass[b], self.place[b]
                far = dx * dx + dy * dy + dz * dz > ti.cast(limit * limit, self.real)
                if ti.select(far | ((mass > 0.0) != (place >= 0)), 1, 0).max() != 0:
                    self.changed[None] = 1
                for lane in range(LANES):
                    row = self.place[b][lane]
                    if row >= 0:
                        self._copy(b, lane, row)
        return self.changed[None]

    @ti.func
    def _copy(self, b, lane, row):
        for c in ti.static(range(3)):
            self.at[row][c] = self.points.state[c, b][lane] - self.folded[c, b][lane]
        self.at[row][3] = self.points.mass[b][lane]
        if ti.static(self.moves):
            for c in ti.static(range(3)):
                self.moving[row][c] = self.points.state[3 + c, b][lane]

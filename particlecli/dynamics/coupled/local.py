"""LocalTerm: a force between every two particles within a cutoff of each other."""

from abc import abstractmethod
from collections.abc import Sequence

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.base import CoupledTerm, Spec
from particlecli.dynamics.coupled.images import Map
from particlecli.dynamics.coupled.neighbor_grid import INTEGERS, VECTOR3
from particlecli.dynamics.coupled.neighbors import Neighbors, Periodic
from particlecli.dynamics.coupled.pairs import over_neighbors, over_packs, target
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.group_plan import LANES


@ti.data_oriented
class LocalTerm(CoupledTerm[Spec]):
    """Sums over neighbours, done before the engine asks for them, for packs of particles that stand together.

    Attributes:
        neighbors: what is near.
        accelerations: field of 4-vectors, one for each row of a particle: three components, m/s², and 0.
        energies: field of packs, J; half of the energy of each pair.
    """

    needs_preparation = True

    def __init__(
        self,
        spec: Spec,
        points: Points,
        groups: Sequence[int],
        cutoff: float,
        *,
        moves: bool = False,
        axes: int = 3,
        periodic: Periodic | None = None,
        maps: Sequence[Map] = (),
    ) -> None:
        super().__init__(spec, points, groups)
        self.neighbors = Neighbors(points, groups, cutoff, moves=moves, axes=axes, periodic=periodic, maps=maps)
        pack = ti.types.vector(LANES, points.real)
        row = ti.types.vector(4, points.real)
        self.accelerations = ti.field(row, shape=points.capacity * LANES)
        self.energies = ti.field(pack, shape=points.capacity)
        self.table = points.memory.table(points.real, np.array(self.parameters()))

    def rearranged(self) -> None:
        """Lists are of no use any more."""
        self.neighbors.forget()

    def prepare(self, time: float) -> None:
        """Sum up forces over all neighbours."""
        self.neighbors.update()
        if self.neighbors.count:
            self._sum_forces(self.neighbors.rows, *self.neighbors.lists)

    def prepare_potential(self, time: float) -> None:
        """Sum up energies over all neighbours."""
        self.neighbors.update()
        if self.neighbors.count:
            self._sum_energies(self.neighbors.rows, *self.neighbors.lists)

    def settle(self) -> None:
        """Fold particles that left a periodic box into it."""
        box = self.neighbors.periodic
        if box is not None:
            self._fold(self.neighbors.rows, ti.Vector(box.low), ti.Vector(box.size))

    @ti.func
    def acceleration(self, p, b, t):
        """Three packs, m/s²."""
        x = 0.0 * self.points.mass[b]
        y, z = x, x
        for lane in range(LANES):
            row = self.neighbors.rows.place[b][lane]
            if row >= 0:
                a = self.accelerations[row]
                x[lane], y[lane], z[lane] = a[0], a[1], a[2]
        return [x, y, z]

    @ti.func
    def potential(self, p, b, t):
        """Of the particles of a pack, J."""
        return ti.select(self.points.mass[b] > 0.0, self.energies[b], 0.0)

    @abstractmethod
    @ti.func
    def force(self, p, d, distance2, here, there):
        """The force by one neighbour, N: see `over_neighbors`; the fourth is 0."""

    @ti.func
    def energy(self, p, d, distance2, here, there):
        """The energy of a pair, J, and three zeros, see `over_neighbors`. Only where `has_potential` is true."""
        raise NotImplementedError

    @ti.func
    def loaded(self):
        """The parameters, in registers."""
        return [self.table[i] for i in ti.static(range(len(self.parameters())))]

    @ti.kernel
    def _fold(self, rows: ti.template(), low: VECTOR3, size: VECTOR3):
        for g in ti.static(self.groups):
            for b in range(self.points.firsts[g], self.points.firsts[g + 1]):
                for c in ti.static(range(3)):
                    if size[c] > 0.0:
                        edge, corner = ti.cast(size[c], self.points.real), ti.cast(low[c], self.points.real)
                        away = edge * ti.floor((self.points.state[c, b] - corner) / edge)
                        self.points.state[c, b] = self.points.state[c, b] - away
                        # Rows stay where they are, and lists hold.
                        rows.origin[c, b] = rows.origin[c, b] - away
                        rows.folded[c, b] = rows.folded[c, b] - away

    @ti.kernel
    def _sum_forces(self, rows: ti.template(), count: ti.i32, begins: INTEGERS, ends: INTEGERS, entries: INTEGERS):
        over_packs(self.accelerate, rows, ti.static((count, begins, ends, entries)))

    @ti.kernel
    def _sum_energies(self, rows: ti.template(), count: ti.i32, begins: INTEGERS, ends: INTEGERS, entries: INTEGERS):
        over_packs(self.weigh, rows, ti.static((count, begins, ends, entries)))

    @ti.func
    def accelerate(self, rows: ti.template(), lists: ti.template(), b, worker):
        """Fill in the accelerations of the particles of a pack, see `over_packs`."""
        count = lists[0]
        here = target(rows, b, count)
        f = over_neighbors(self.force, self.loaded(), rows, lists, b, here, worker)
        for k in ti.static(range(rows.width)):
            row = b * rows.width + k
            if row < count:
                mass = here[3][k]
                self.accelerations[row] = ti.Vector([f[0][k] / mass, f[1][k] / mass, f[2][k] / mass, 0.0])

    @ti.func
    def weigh(self, rows: ti.template(), lists: ti.template(), b, worker):
        """Fill in the energies of the particles of a pack, see `over_packs`."""
        count = lists[0]
        here = target(rows, b, count)
        total = over_neighbors(self.energy, self.loaded(), rows, lists, b, here, worker)
        for k in ti.static(range(rows.width)):
            if b * rows.width + k < count:
                slot = rows.order[b * rows.width + k]
                self.energies[slot // LANES][slot % LANES] = 0.5 * total[0][k]

"""Points: all particles of the groups that coupled forces act on, as those forces see them."""

from collections.abc import Mapping

import numpy as np
import taichi as ti

from particlecli import runtime
from particlecli.dynamics.group_plan import LANES
from particlecli.dynamics.memory import FieldMemory


@ti.data_oriented
class Points:
    """Positions, velocities and masses of all coupled particles at the present stage of a step.

    Particles stand in packs of 16 lanes. Each group begins at a whole pack and keeps its particles in their order:
    lane `l` of pack `firsts[g] + k` is particle 16 k + l of group `g`, and a particle's number among the points is
    16 times its pack plus its lane. Packs are handed out again when the numbers of particles change, at the beginning
    of a frame, so there are no empty packs between groups. Lanes without a particle, and particles that are not born
    yet or have died within the frame, have mass 0 and a finite position: they must not act on others. What is computed
    for them is not used.

    Args:
        capacities: particles there is room for, by group.
        real: type of numbers, ti.f32 or ti.f64.
        memory: of the system.

    Attributes:
        memory: where tables that forces need go.
        names: of the groups, in their order.
        state: field of packs, shape (6, packs): x, y, z, m, and u, v, w, m/s.
        mass: field of packs, kg; zero for lanes that do not act.
        firsts: field of i32, shape (groups + 1): the first pack of each group, and the end of the last.
        counts: field of i32, shape (groups): the particles of each group.
        first_packs, populations: the same two as arrays.
        capacities: of the groups, particles there is room for.
        capacity: packs there is room for.
    """

    def __init__(self, capacities: Mapping[str, int], real, memory: FieldMemory) -> None:
        runtime.use(self, wears=True)
        self.memory = memory
        self.names = tuple(capacities)
        self.real = real
        self.real_dtype = np.float64 if real == ti.f64 else np.float32
        self.capacities = tuple(capacities.values())
        self.capacity = sum(-(-capacity // LANES) for capacity in capacities.values())
        pack = ti.types.vector(LANES, real)
        self.state = ti.field(pack, shape=(6, self.capacity))
        self.mass = ti.field(pack, shape=self.capacity)
        self.firsts = ti.field(ti.i32, shape=len(self.names) + 1)
        self.counts = ti.field(ti.i32, shape=len(self.names))
        self._views = memory.view(self.firsts), memory.view(self.counts)
        self._hand_out([0] * len(self.names))

    def arrange(self, populations: list[int]) -> None:
        """Hand out packs to groups of so many particles."""
        self._hand_out(populations)
        firsts, counts = self._views
        firsts.array[:], counts.array[:] = self.first_packs, self.populations

    def _hand_out(self, populations: list[int]) -> None:
        self.populations = np.array(populations, np.int32)
        self.first_packs = np.concatenate(([0], np.cumsum(-(-self.populations // LANES)))).astype(np.int32)

    @property
    def packs(self) -> int:
        """Packs in use."""
        return int(self.first_packs[-1])

    def index(self, group: str) -> int:
        """The place of a group."""
        return self.names.index(group)

    @ti.func
    def holds(self, g: ti.template(), b):
        """Whether pack b belongs to group g."""
        return (b >= self.firsts[g]) & (b < self.firsts[g + 1])

    @ti.func
    def gathered(self, row: ti.template(), numbers, first):
        """A row of the state of particles of given numbers, a pack, in the group that begins at pack `first`."""
        return self.gathered_from(self.state, row, numbers, first)

    @ti.func
    def gathered_from(self, field: ti.template(), row, numbers, first):
        """The same of another field of packs."""
        pack = field[row, first]
        # A loop, not 16 lines: LLVM unrolls it as well, and Taichi is spared them.
        for lane in range(LANES):
            pack[lane] = field[row, first + (numbers[lane] >> 4)][numbers[lane] & 15]
        return pack

    @ti.func
    def position(self, b):
        """Packs x, y, z."""
        return [self.state[0, b], self.state[1, b], self.state[2, b]]

    @ti.func
    def velocity(self, b):
        """Packs u, v, w."""
        return [self.state[3, b], self.state[4, b], self.state[5, b]]

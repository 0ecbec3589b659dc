"""Damped springs between particles of a group."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli.dynamics.coupled.base import CoupledTerm
from particlecli.dynamics.coupled.links import Adjacency, Lattice, places
from particlecli.dynamics.coupled.partner_packs import PartnerPacks
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.expressions import evaluate
from particlecli.dynamics.group_plan import LANES, GroupPlan
from particlecli.errors import SimulationError
from particlecli.scene import forces as scene
from particlecli.scene.shapes import LinkedLayout


class Springs(CoupledTerm[scene.Springs]):
    """F = −(k (|l| − r) + d l′·l/|l|) l/|l|, U = ½ k (|l| − r)².

    Symbols: l from one end to the other, m; l′ its rate of change, m/s; k stiffness, N/m; r rest length, m; d damping,
    N s/m. A spring whose ends are at the same place pulls in no direction.
    A particle looks its springs up in a table that has each of them twice, once for each end, in the same order for
    all time: so both ends get the same force to the last bit, in opposite directions, whatever thread computes them.
    Source: Witkin & Baraff, Physically Based Modeling (SIGGRAPH 1997), C, eq. 1.

    Args:
        plans: of all groups of `points`, in their order.

    Attributes:
        positions: for each of `groups`, where its particles are at first, m, shape (3, particles).
    """

    has_potential = True
    joins = True

    def __init__(self, spec: scene.Springs, points: Points, groups: Sequence[int], plans: Sequence[GroupPlan]) -> None:
        super().__init__(spec, points, groups)
        self.needs_places = bool({"s", "side"} & spec.rest_length.names)
        self.ends_steps = spec.breaks_at is not None
        self.positions = [plans[g].births.table(0, plans[g].births.total).positions for g in groups]
        tables = [_table(spec, plans[g], at) for g, at in zip(groups, self.positions, strict=True)]
        self.first_rows = np.cumsum([0, *(len(starts) for starts, *_ in tables)]).tolist()
        slots = np.cumsum([0, *(len(partners) for _, partners, *_ in tables)])
        starts = np.concatenate([table[0] + slot for table, slot in zip(tables, slots, strict=False)])
        self.starts = points.memory.table(ti.i32, starts)
        self._starts = starts
        partners, steps, *columns = (np.concatenate([table[i] for table in tables]) for i in range(1, 6))
        self.original = partners
        rows = max(1, len(partners))
        self.partners = ti.field(ti.types.vector(LANES, ti.i32), shape=rows)
        pack = ti.types.vector(LANES, points.real)
        self.columns = ti.field(pack, shape=(3 if self.needs_places else 1, rows))
        if len(partners):
            points.memory.view(self.columns, np.stack(columns[: 3 if self.needs_places else 1]))
        self.stiff = ti.field(pack, shape=(rows if plans[0].implicit else 1, 4))
        self.partner_packs = PartnerPacks(steps, self.partners, points, groups)
        self._partners = points.memory.view(self.partners, partners if len(partners) else None)

    def restart(self) -> None:
        """Make every spring whole."""
        if len(self.original):
            self._partners.array[...] = self.original

    def joined(self) -> list[NDArray[np.int64]]:
        """For each of `groups`, the numbers of the particles that whole springs join, shape (springs, 2)."""
        return [pairs for pairs, _ in self._once(self._partners.array)]

    def ends(self) -> tuple[list[NDArray[np.int64]], list[NDArray[np.int64]]]:
        """The same of all springs, and for each of them the number of its entry in the table, 16 slot + lane."""
        found = self._once(self.original)
        return [pairs for pairs, _ in found], [places for _, places in found]

    def _once(self, partners):
        starts = self._starts
        found = []
        for first, last in pairwise(self.first_rows):
            packs = np.repeat(np.arange(last - first - 1), np.diff(starts[first:last]))
            others = partners[starts[first] : starts[last - 1]]
            owners = packs[:, None] * LANES + np.arange(LANES)
            once = owners < others
            pairs = np.stack([owners[once], others[once]], axis=1).astype(np.int64)
            found.append((pairs, starts[first] * LANES + np.flatnonzero(once)))
        return found

    def parameters(self) -> list[float]:
        """Stiffness, damping, strain at which springs break."""
        return [self.spec.stiffness, self.spec.damping, self.spec.breaks_at or 0.0]

    @ti.func
    def acceleration(self, p, b, t):
        """Three packs, m/s²."""
        mass = self.points.mass[b]
        fx, fy, fz = 0.0 * mass, 0.0 * mass, 0.0 * mass
        first, row = self._place(b)
        for slot in range(self.starts[row], self.starts[row + 1]):
            dx, dy, dz, length, inverse = self._span(slot, b, first)
            pull = p[0] * (length - self._rest(slot, t))
            if ti.static(self.spec.damping > 0):
                du, dv, dw = self._apart(3, slot, b, first)
                pull += p[1] * (du * dx + dv * dy + dw * dz) * inverse
            pull = ti.select(self._joins(slot, b, first), pull * inverse, 0.0)
            fx, fy, fz = fx + pull * dx, fy + pull * dy, fz + pull * dz
        weight = ti.select(mass > 0.0, 1.0 / mass, 0.0)
        return [weight * fx, weight * fy, weight * fz]

    @ti.func
    def potential(self, p, b, t):
        """Half the energy of each spring of the particles of a pack, J."""
        energy = 0.0 * self.points.mass[b]
        first, row = self._place(b)
        for slot in range(self.starts[row], self.starts[row + 1]):
            stretch = self._span(slot, b, first)[3] - self._rest(slot, t)
            energy += ti.select(self._joins(slot, b, first), 0.25 * p[0] * stretch * stretch, 0.0)
        return energy

    @ti.func
    def linearize(self, p, b, t, by_position, by_velocity):
        """As of `CoupledTerm`: of each spring n nᵀ + c 1, n along it; without the part that bends under pressure."""
        zero = 0.0 * self.points.mass[b]
        xx, xy, xz, yy, yz, zz = zero, zero, zero, zero, zero, zero
        first, row = self._place(b)
        for slot in range(self.starts[row], self.starts[row + 1]):
            dx, dy, dz, _, inverse = self._span(slot, b, first)
            nx, ny, nz = dx * inverse, dy * inverse, dz * inverse
            joins = self._joins(slot, b, first)
            taut = ti.max(0.0, 1.0 - self._rest(slot, t) * inverse)
            c = ti.select(joins, by_position * p[0] * taut, 0.0)
            s = ti.select(joins, by_position * p[0] * (1.0 - taut) + by_velocity * p[1], 0.0)
            root = ti.sqrt(s)
            for j in ti.static(range(4)):
                self.stiff[slot, j] = [root * nx, root * ny, root * nz, c][j]
            xx, xy, xz = xx + s * nx * nx + c, xy + s * nx * ny, xz + s * nx * nz
            yy, yz, zz = yy + s * ny * ny + c, yz + s * ny * nz, zz + s * nz * nz + c
        return [xx, xy, xz, yy, yz, zz]

    @ti.func
    def apply(self, b, vectors: ti.template()):
        """As of `CoupledTerm`."""
        zero = 0.0 * self.points.mass[b]
        x, y, z = zero, zero, zero
        first, row = self._place(b)
        for slot in range(self.starts[row], self.starts[row + 1]):
            qx, qy, qz = self.partner_packs.vectors(vectors, 0, slot, b, first)
            nx, ny, nz, c = self.stiff[slot, 0], self.stiff[slot, 1], self.stiff[slot, 2], self.stiff[slot, 3]
            along = nx * qx + ny * qy + nz * qz
            x, y, z = x - along * nx - c * qx, y - along * ny - c * qy, z - along * nz - c * qz
        return [x, y, z]

    @ti.func
    def link(self, place):
        """√s n and c of the spring of entry `place`, four numbers, as of `linearize`."""
        slot, lane = place // LANES, place % LANES
        return ti.Vector([self.stiff[slot, j][lane] for j in ti.static(range(4))])

    @ti.func
    def tautness(self, place):
        """c of that spring alone."""
        return self.stiff[place // LANES, 3][place % LANES]

    @ti.func
    def end_step(self, p, b, t):
        """Break the springs of a pack that are stretched too far."""
        first, row = self._place(b)
        for slot in range(self.starts[row], self.starts[row + 1]):
            rest = self._rest(slot, t)
            overstretched = self._span(slot, b, first)[3] - rest > p[2] * rest
            self.partners[slot] = ti.select(overstretched, self._own(b, first), self.partners[slot])

    @ti.func
    def _place(self, b):
        """The first pack of the group of pack b, and the row of the pack in `starts`."""
        first, row = 0, 0
        for i in ti.static(range(len(self.groups))):
            if self.points.holds(self.groups[i], b):
                first = self.points.firsts[self.groups[i]]
                row = self.first_rows[i] + b - first
        return [first, row]

    @ti.func
    def _span(self, slot, b, first):
        """From a pack's particles to their partners: components and length, m, and 1/length or zero."""
        dx, dy, dz = self._apart(0, slot, b, first)
        length = ti.sqrt(dx * dx + dy * dy + dz * dz)
        return [dx, dy, dz, length, ti.select(length > 0.0, 1.0 / length, 0.0)]

    @ti.func
    def _apart(self, row: ti.template(), slot, b, first):
        """Three rows of the state of a pack's partners less those of its particles; finite without a partner."""
        x, y, z = self.partner_packs.vectors(self.points.state, row, slot, b, first)
        return [x - self.points.state[row, b], y - self.points.state[row + 1, b], z - self.points.state[row + 2, b]]

    @ti.func
    def _joins(self, slot, b, first):
        """Mask of the particles of a pack that have a whole spring in a slot."""
        return self.partners[slot] != self._own(b, first)

    @ti.func
    def _own(self, b, first):
        """The numbers of a pack's own particles."""
        return ti.Vector(list(range(LANES))) + (b - first) * LANES

    @ti.func
    def _rest(self, slot, t):
        """Rest lengths of the springs of a slot, m."""
        length = self.columns[0, slot]
        s, side = length, length
        if ti.static(self.needs_places):
            s, side = self.columns[1, slot], self.columns[2, slot]
        return 0.0 * length + self._rest_length({"l": length, "t": t, "s": s, "side": side})

    def _rest_length(self, names):
        return evaluate(self.spec.rest_length, names)


def _table(spec: scene.Springs, plan: GroupPlan, positions):
    """Starts, partners and steps as of `Adjacency`; and of each entry the distance at first, s and side.

    The last three have shape (slots, 16); positions at first, m, (3, particles).
    """
    if spec.pairs is not None:
        pairs = np.array(spec.pairs, np.int64)
    elif isinstance(plan.layout, LinkedLayout):
        pairs = Lattice.of(plan.layout).pairs(spec.links or ("structural", "shear", "bend"))
    else:
        raise ValueError(f"the particles of {plan.name} are not linked")
    if pairs.size and pairs.max() >= positions.shape[1]:
        raise SimulationError(
            f"springs join particle {pairs.max()} of group {plan.name}, which has {positions.shape[1]} particles, "
            "numbered from 0"
        )
    adjacency = Adjacency.of(pairs, positions.shape[1])
    lengths = np.linalg.norm(positions[:, pairs[:, 0]] - positions[:, pairs[:, 1]], axis=0)
    middles = [each[pairs].mean(axis=1) for each in places(plan.layout, positions.shape[1])]
    # Lanes without a spring have the length and place of the last one, for which a rest length is sure to be finite.
    columns = [(values if len(values) else np.zeros(1))[adjacency.links] for values in (lengths, *middles)]
    return adjacency.starts, adjacency.partners, adjacency.steps(), *columns

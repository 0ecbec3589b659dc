"""A coarse correction of implicit steps: particles that springs join move together, as rigid bodies.

Stiff springs let particles turn around each other, so what is hard to find by steps from spring to spring are motions of
whole parts that turn against each other. Bodies that move and turn represent them (rigid body modes in aggregates:
Vaněk, Mandel & Brezina, Computing 56 (1996) 179; Bulgakov & Kuhn, Int. J. Numer. Meth. Eng. 38 (1995) 3529).
With T = (1, −[r]×), which leads from the velocity and the spin of a body to that of a particle at r from its centre, the
equations of the bodies are Tᵀ A T. They are solved directly.
"""

from collections.abc import Sequence

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.block_factor import SIX, WIDTH, BlockFactor
from particlecli.dynamics.coupled.bodies import Graph, bodies
from particlecli.dynamics.coupled.pins import Pins
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.coupled.sharing import GRAIN, SHARE, TURNS
from particlecli.dynamics.coupled.springs import Springs
from particlecli.dynamics.group_plan import LANES


@ti.data_oriented
class RigidBodies:
    """The bodies, their equations, and what they make of what is left of Newton's equations.

    Packs of the groups that springs act on are rows, one after the other; a particle's place is 16 row + lane.

    Args:
        springs: the forces whose particles are gathered.
        points: all particles.
        pins: those that do not move.
        alone: field of packs, shape (6, packs): blocks xx, xy, xz, yy, yz, zz, kg, that are no springs'.

    Attributes:
        count: how many bodies; with none there is nothing else.
        rest: field of packs, shape (3, rows): what is left.
    """

    def __init__(self, springs: Sequence[Springs], points: Points, pins: Pins, alone) -> None:
        self.springs, self.points, self.alone = list(springs), points, alone
        self.groups = sorted({g for each in springs for g in each.groups})
        rows = [-(-self.points.capacities[g] // LANES) for g in self.groups]
        self.rows = np.cumsum([0, *rows]).tolist()
        graph, free, places = self._particles(pins)
        owners, elimination = bodies(graph, free)
        self.count = elimination.count
        if self.count:
            self.factor = BlockFactor(elimination, points)
            self._lay_out(graph, owners, places, elimination.numbers())

    def _particles(self, pins: Pins):
        """The graph of the springs, which particles of it move, and where each spring is found, by force."""
        count = self.rows[-1] * LANES
        pairs, weights, places = [np.empty((0, 2), np.int64)], [np.empty(0)], []
        for each in self.springs:
            joined, found = each.ends()
            firsts = [self.rows[self.groups.index(g)] * LANES for g in each.groups]
            pairs += [ends + first for ends, first in zip(joined, firsts, strict=True)]
            places.append(np.concatenate(found))
            weights.append(np.full(len(places[-1]), each.spec.stiffness))
        free = np.ones(count, bool)
        for row, g in zip(self.rows, self.groups, strict=False):
            pinned = pins.pinned(g)
            free[row * LANES : row * LANES + len(pinned)] = ~pinned
        return Graph(count, np.concatenate(pairs), np.concatenate(weights)), free, places

    def _lay_out(self, graph: Graph, owners, places, numbers) -> None:
        table, real = self.points.memory.table, self.points.real
        self.links = np.cumsum([0, *map(len, places)]).tolist()
        self.places = table(ti.i32, np.concatenate(places))
        self.ends = table(ti.i32, graph.pairs)
        self.stiff = ti.field(ti.types.vector(4, real), shape=len(graph.pairs))
        pack = ti.types.vector(LANES, real)
        self.rest, self.arms = (ti.field(pack, shape=(3, self.rows[-1])) for _ in range(2))
        self.owners = ti.field(ti.types.vector(LANES, ti.i32), shape=self.rows[-1])
        self.points.memory.view(self.owners, np.where(owners >= 0, owners, self.count).reshape(-1, LANES))
        members = np.flatnonzero(owners >= 0)
        self._members = members[np.argsort(owners[members], kind="stable")]
        self.member_starts, self.members = self._listed(owners[members], members, self.count)
        self._sort_links(graph.pairs, owners, numbers)
        self.counters = ti.field(ti.i32, shape=2)

    def _sort_links(self, pairs, owners, numbers) -> None:
        """The links inside of each body; those that leave it, by its members; and by blocks beside the diagonal.

        The last as 2 link, and 1 more if it is the other way round.
        """
        ends, links = owners[pairs], np.arange(len(pairs))
        inside = (ends[:, 0] == ends[:, 1]) & (ends[:, 0] >= 0)
        self.inner_starts, self.inner = self._listed(ends[inside, 0], links[inside], self.count)
        ranks = np.full(len(owners), -1)
        ranks[self._members] = np.arange(len(self._members))
        leaves = [(ends[:, way] >= 0) & ~inside for way in range(2)]
        found = np.concatenate([ranks[pairs[leaves[way], way]] for way in range(2)])
        numbered = np.concatenate([links[each] for each in leaves])
        self.leaving_starts, self.leaving = self._listed(found, numbered, len(self._members))
        below = [leaves[way] & (ends[:, 1 - way] >= 0) & (ends[:, way] > ends[:, 1 - way]) for way in range(2)]
        found = np.concatenate([ends[below[way]][:, [way, 1 - way]] for way in range(2)])
        blocks = np.array([numbers[i, j] for i, j in found.tolist()], np.int64)
        numbered = np.concatenate([2 * links[below[way]] + way for way in range(2)])
        self.outer_starts, self.outer = self._listed(blocks, numbered, len(numbers))

    def _listed(self, owners, entries, count: int):
        """The entries of each of `count` owners: where they begin, and the end of the last; and they."""
        starts = np.concatenate([[0], np.cumsum(np.bincount(owners, minlength=count))])
        found = entries[np.lexsort((entries, owners))] if len(entries) else np.zeros(1, np.int64)
        return self.points.memory.table(ti.i32, starts), self.points.memory.table(ti.i32, found)

    @ti.kernel
    def refresh(self):
        """Put the equations of the bodies together and factorize them, for particles and springs as they are now."""
        for body in range(self.count):
            self._center(body)
        for j in ti.static(range(len(self.springs))):
            for e in range(self.links[j], self.links[j + 1]):
                self.stiff[e] = self.springs[j].link(self.places[e])
        self.counters[0], self.counters[1] = 0, 0
        for turn in range(TURNS):
            if turn % GRAIN == 0:
                first = ti.atomic_add(self.counters[1], SHARE)
                while first < self.count + self.factor.blocks:
                    for block in range(first, ti.min(first + SHARE, self.count + self.factor.blocks)):
                        self._assemble(block)
                    first = ti.atomic_add(self.counters[1], SHARE)
        for turn in range(TURNS):
            if turn % GRAIN == 0:
                branch = ti.atomic_add(self.counters[0], 1)
                while branch < self.factor.branches:
                    for k in range(self.factor.firsts[branch], self.factor.firsts[branch + 1]):
                        self.factor.eliminate(k)
                    branch = ti.atomic_add(self.counters[0], 1)
        ti.loop_config(serialize=True)
        for k in range(self.factor.trunk, self.count):
            self.factor.eliminate(k)
        for e in range(self.count + self.factor.blocks):
            self.factor.keep(e)

    @ti.func
    def _center(self, body):
        """Where the particles of a body are, from its centre."""
        center, count = ti.Vector.zero(self.points.real, 3), 0
        for m in range(self.member_starts[body], self.member_starts[body + 1]):
            center, count = center + self._position(self.members[m]), count + 1
        center /= ti.cast(count, self.points.real)
        for m in range(self.member_starts[body], self.member_starts[body + 1]):
            place = self.members[m]
            arm = self._position(place) - center
            for c in ti.static(range(3)):
                self.arms[c, place >> 4][place & 15] = arm[c]

    @ti.func
    def _position(self, place):
        b = self.pack(place >> 4)
        return ti.Vector([self.points.state[c, b][place & 15] for c in ti.static(range(3))])

    @ti.func
    def _assemble(self, number):
        """Block by block Tᵀ A T, in double precision, for it has stiff springs beside light masses."""
        if number < self.count:
            self._assemble_body(number)
        else:
            zero = ti.Vector.zero(ti.f64, WIDTH)
            u, v, w, p, q, r = zero, zero, zero, zero, zero, zero
            for s in range(self.outer_starts[number - self.count], self.outer_starts[number - self.count + 1]):
                link, way = self.outer[s] >> 1, self.outer[s] & 1
                block = self._block(ti.cast(self.stiff[link], ti.f64))
                rows = self._projected(block, self.ends[link, way], self.ends[link, 1 - way])
                u, v, w, p, q, r = u - rows[0], v - rows[1], w - rows[2], p - rows[3], q - rows[4], r - rows[5]
            for k in ti.static(range(SIX)):
                self.factor.values[number, k] = [u, v, w, p, q, r][k]

    @ti.func
    def _assemble_body(self, body):
        """The block of a body: of its particles, of links that leave it, and of those inside, which resist its turns."""
        zero, none = ti.Vector.zero(ti.f64, WIDTH), ti.cast(0.0, ti.f64)
        u, v, w, p, q, r = zero, zero, zero, zero, zero, zero
        for m in range(self.member_starts[body], self.member_starts[body + 1]):
            place = self.members[m]
            rows = self._projected(self._held(m), place, place)
            u, v, w, p, q, r = u + rows[0], v + rows[1], w + rows[2], p + rows[3], q + rows[4], r + rows[5]
        xx, xy, xz, yy, yz, zz = none, none, none, none, none, none
        for s in range(self.inner_starts[body], self.inner_starts[body + 1]):
            link = self.inner[s]
            d, c = self._arm(self.ends[link, 0]) - self._arm(self.ends[link, 1]), ti.cast(self.stiff[link][3], ti.f64)
            xx, xy, xz = xx + c * (d[1] * d[1] + d[2] * d[2]), xy - c * d[0] * d[1], xz - c * d[0] * d[2]
            yy, yz, zz = yy + c * (d[0] * d[0] + d[2] * d[2]), yz - c * d[1] * d[2], zz + c * (d[0] * d[0] + d[1] * d[1])
        p += ti.Vector([0.0, 0.0, 0.0, xx, xy, xz, 0.0, 0.0], ti.f64)
        q += ti.Vector([0.0, 0.0, 0.0, xy, yy, yz, 0.0, 0.0], ti.f64)
        r += ti.Vector([0.0, 0.0, 0.0, xz, yz, zz, 0.0, 0.0], ti.f64)
        for k in ti.static(range(SIX)):
            self.factor.values[body, k] = [u, v, w, p, q, r][k]

    @ti.func
    def _held(self, m):
        """The block of member m: its own, and those of links that leave its body."""
        place = self.members[m]
        b, lane = self.pack(place >> 4), place & 15
        held = ti.Vector([ti.cast(self.alone[c, b][lane], ti.f64) for c in ti.static(range(6))])
        for s in range(self.leaving_starts[m], self.leaving_starts[m + 1]):
            held += self._block(ti.cast(self.stiff[self.leaving[s]], ti.f64))
        return held

    @ti.func
    def _block(self, link):
        """xx, xy, xz, yy, yz, zz of a link of √s n and c."""
        x, y, z, c = link[0], link[1], link[2], link[3]
        return ti.Vector([x * x + c, x * y, x * z, y * y + c, y * z, z * z + c])

    @ti.func
    def _projected(self, block, one, other):
        """T₁ᵀ B T₂ of the particles at two places, six rows."""
        arm, image = self._arm(one), self._image(block, self._arm(other))
        x, y, z = arm[0], arm[1], arm[2]
        return image + [y * image[2] - z * image[1], z * image[0] - x * image[2], x * image[1] - y * image[0]]

    @ti.func
    def _image(self, block, arm):
        """B T, three rows."""
        x, y, z = arm[0], arm[1], arm[2]
        first = ti.Vector([1.0, 0.0, 0.0, 0.0, z, -y, 0.0, 0.0], ti.f64)
        second = ti.Vector([0.0, 1.0, 0.0, -z, 0.0, x, 0.0, 0.0], ti.f64)
        third = ti.Vector([0.0, 0.0, 1.0, y, -x, 0.0, 0.0, 0.0], ti.f64)
        return [
            block[0] * first + block[1] * second + block[2] * third,
            block[1] * first + block[3] * second + block[4] * third,
            block[2] * first + block[4] * second + block[5] * third,
        ]

    @ti.func
    def _arm(self, place):
        return ti.Vector([ti.cast(self.arms[c, place >> 4][place & 15], ti.f64) for c in ti.static(range(3))])

    @ti.func
    def pack(self, row):
        """The pack of points in a row."""
        b = row
        for i in ti.static(range(len(self.groups))):
            if row >= self.rows[i]:
                b = self.points.firsts[self.groups[i]] + row - self.rows[i]
        return b

    @ti.func
    def row(self, b):
        """The row of a pack of points, −1 where no spring can be."""
        row = -1
        for i in ti.static(range(len(self.groups))):
            if self.points.holds(self.groups[i], b):
                row = self.rows[i] + b - self.points.firsts[self.groups[i]]
        return row

    @ti.func
    def begin(self, branch):
        """Solve for the bodies of a branch with those before them, from `rest`."""
        for k in range(self.factor.firsts[branch], self.factor.firsts[branch + 1]):
            self.factor.descend(k, self._gathered(k))

    @ti.func
    def turn(self):
        """Solve for the bodies of the trunk, once all branches have begun; returns what was found times what was left."""
        for k in range(self.factor.trunk, self.count):
            self.factor.descend(k, self._gathered(k))
        for k in range(self.count - self.factor.trunk):
            self.factor.ascend(self.count - 1 - k)
        return self.factor.product()

    @ti.func
    def end(self, branch):
        """Solve for the bodies of a branch."""
        first, last = self.factor.firsts[branch], self.factor.firsts[branch + 1]
        for k in range(last - first):
            self.factor.ascend(last - 1 - k)

    @ti.func
    def _gathered(self, body):
        """The force and the torque that are left on a body."""
        found = 0.0 * self.factor.halfway[body]
        for m in range(self.member_starts[body], self.member_starts[body + 1]):
            row, lane = self.members[m] >> 4, self.members[m] & 15
            fx, fy, fz = self.rest[0, row][lane], self.rest[1, row][lane], self.rest[2, row][lane]
            x, y, z = self.arms[0, row][lane], self.arms[1, row][lane], self.arms[2, row][lane]
            found += ti.Vector([fx, fy, fz, y * fz - z * fy, z * fx - x * fz, x * fy - y * fx, 0.0, 0.0])
        return found

    @ti.func
    def moved(self, row):
        """What the particles of a row get from their bodies, three packs."""
        x, y, z = self.arms[0, row], self.arms[1, row], self.arms[2, row]
        u, v, w, p, q, r = x, x, x, x, x, x
        for lane in range(LANES):
            body = self.owners[row][lane]
            u[lane], v[lane], w[lane] = [self.factor.solution[body][c] for c in ti.static(range(3))]
            p[lane], q[lane], r[lane] = [self.factor.solution[body][c] for c in ti.static(range(3, 6))]
        return [u + q * z - r * y, v + r * x - p * z, w + p * y - q * x]


"""The equations of rigid bodies that springs hold: from those of their particles, block by block."""

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.block_factor import SIX, WIDTH
from particlecli.dynamics.coupled.blocks import total
from particlecli.dynamics.coupled.spring_rows import SpringRows
from particlecli.dynamics.group_plan import LANES


@ti.data_oriented
class BodyEquations:
    """Tᵀ A T, with T = (1, −[r]×), which leads from the velocity and the spin of a body to that of a particle.

    All is summed up in double precision, for it has stiff springs beside light masses.

    Args:
        rows: the particles.
        alone: field of packs, shape (6, packs): their blocks xx, xy, xz, yy, yz, zz, kg, without those of springs.
        owners: the body of each place, −1 for none, shape (16 rows).
        numbers: of blocks beside the diagonal, by row and column.

    Attributes:
        count: bodies.
        members: field of i32: the places of the particles of each body.
        member_starts: field of i32, shape (count + 1): where each body's begin, and the end of the last.
        arms: field of packs, shape (3, rows): where particles are from the centre of their body, m.
        sums: field of packs of f64, shape (6, bodies): what is summed up of each body's particles.
        owners: field of packs of i32, shape (rows): the body of each place, −1 for none.
        row_starts, body_rows: fields of i32: the rows that each body has particles in, as `members`.
        body_starts, row_bodies: fields of i32: the bodies that have particles in each row.
        links: springs by force: where each force's begin, and the end of the last.
    """

    def __init__(self, rows: SpringRows, alone, owners, numbers: dict[tuple[int, int], int]) -> None:
        self.rows, self.points, self.alone = rows, rows.points, alone
        table, real = self.points.memory.table, self.points.real
        graph, entries = rows.graph()
        self.count = int(owners.max()) + 1
        self.links = np.cumsum([0, *map(len, entries)]).tolist()
        self.entries, self.ends = table(ti.i32, np.concatenate(entries)), table(ti.i32, graph.pairs)
        self.arms = ti.field(ti.types.vector(LANES, real), shape=(3, rows.count))
        self.sums = ti.field(ti.types.vector(LANES, ti.f64), shape=(SIX, self.count))
        self.centers = ti.field(ti.types.vector(3, real), shape=self.count)
        members = np.flatnonzero(owners >= 0)
        self._members = members[np.argsort(owners[members], kind="stable")]
        self.member_starts, self.members = self._listed(owners[members], members, self.count)
        self.owners = ti.field(ti.types.vector(LANES, ti.i32), shape=rows.count)
        self.points.memory.view(self.owners, owners.astype(np.int32).reshape(-1, LANES))
        pairs = np.unique(np.stack([self._members // LANES, owners[self._members]]), axis=1)
        self.row_starts, self.body_rows = self._listed(pairs[1], pairs[0], self.count)
        self.body_starts, self.row_bodies = self._listed(pairs[0], pairs[1], rows.count)
        self._sort_links(graph.pairs, owners, numbers)

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

    @ti.func
    def _link(self, e):
        """√s n and c of link e, as of `Springs.linearize`, in double precision."""
        found = ti.Vector.zero(ti.f64, 4)
        for j in ti.static(range(len(self.rows.springs))):
            if self._belongs(j, e):
                found = ti.cast(self.rows.springs[j].link(self.entries[e]), ti.f64)
        return found

    @ti.func
    def _tautness(self, e):
        """c of link e alone."""
        found = ti.cast(0.0, ti.f64)
        for j in ti.static(range(len(self.rows.springs))):
            if self._belongs(j, e):
                found = ti.cast(self.rows.springs[j].tautness(self.entries[e]), ti.f64)
        return found

    @ti.func
    def _belongs(self, j: ti.template(), e):
        """Whether link e is of force j."""
        return (e >= self.links[j]) & (e < self.links[j + 1])

    @ti.func
    def center(self, body):
        """Find the centre of a body."""
        zero = 0.0 * self.arms[0, 0]
        x, y, z, count = zero, zero, zero, zero
        for s in range(self.row_starts[body], self.row_starts[body + 1]):
            row = self.body_rows[s]
            b, own = self.rows.pack(row), self.owners[row] == body
            x += ti.select(own, self.points.state[0, b], 0.0)
            y += ti.select(own, self.points.state[1, b], 0.0)
            z += ti.select(own, self.points.state[2, b], 0.0)
            count += ti.select(own, 1.0, 0.0)
        for c in ti.static(range(4)):
            self.sums[c, body] = ti.cast([x, y, z, count][c], ti.f64)
        for c in ti.static(range(3)):
            center = total(self.sums, c, body) / total(self.sums, 3, body)
            self.centers[body][c] = ti.cast(center, self.points.real)

    @ti.func
    def reach(self, row):
        """Find where the particles of a row are from the centres of their bodies."""
        b = self.rows.pack(row)
        for s in range(self.body_starts[row], self.body_starts[row + 1]):
            body = self.row_bodies[s]
            own, center = self.owners[row] == body, self.centers[body]
            for c in ti.static(range(3)):
                self.arms[c, row] = ti.select(own, self.points.state[c, b] - center[c], self.arms[c, row])

    @ti.func
    def assemble(self, values: ti.template(), number):
        """Block by block Tᵀ A T, in double precision, for it has stiff springs beside light masses."""
        if number < self.count:
            self._assemble_body(values, number)
        else:
            self._assemble_between(values, number)

    @ti.func
    def _assemble_between(self, values: ti.template(), number):
        """The block of two bodies: of each link −T₁ᵀ (n nᵀ + c) T₂, whose first part is of the moments n, r × n."""
        zero, none = ti.Vector.zero(ti.f64, WIDTH), ti.Vector.zero(ti.f64, 4)
        u, v, w, p, q, r = zero, zero, zero, zero, zero, zero
        whole, x, y, z = none, none, none, none
        for s in range(self.outer_starts[number - self.count], self.outer_starts[number - self.count + 1]):
            link, way = self.outer[s] >> 1, self.outer[s] & 1
            n = self._link(link)
            arm, other = self._arm(self.ends[link, way]), self._arm(self.ends[link, 1 - way])
            moment = _moment(n, other)
            u, v, w = u - n[0] * moment, v - n[1] * moment, w - n[2] * moment
            p -= (arm[1] * n[2] - arm[2] * n[1]) * moment
            q -= (arm[2] * n[0] - arm[0] * n[2]) * moment
            r -= (arm[0] * n[1] - arm[1] * n[0]) * moment
            held = n[3] * ti.Vector([1.0, other[0], other[1], other[2]], ti.f64)
            whole, x, y, z = whole - held, x - arm[0] * held, y - arm[1] * held, z - arm[2] * held
        rows = _spread(whole, x, y, z)
        for k in ti.static(range(SIX)):
            values[number, k] = [u, v, w, p, q, r][k] + rows[k]

    @ti.func
    def _assemble_body(self, values: ti.template(), body):
        """The block of a body: of its particles, of links that leave it, and of those inside, which resist turns."""
        zero, none = ti.Vector.zero(ti.f64, WIDTH), ti.cast(0.0, ti.f64)
        u, v, w, p, q, r = zero, zero, zero, zero, zero, zero
        for m in range(self.member_starts[body], self.member_starts[body + 1]):
            place = self.members[m]
            rows = self._projected(self._held(m), place, place)
            u, v, w, p, q, r = u + rows[0], v + rows[1], w + rows[2], p + rows[3], q + rows[4], r + rows[5]
        xx, xy, xz, yy, yz, zz = none, none, none, none, none, none
        for s in range(self.inner_starts[body], self.inner_starts[body + 1]):
            link = self.inner[s]
            c = self._tautness(link)
            if c > 0.0:
                d = self._arm(self.ends[link, 0]) - self._arm(self.ends[link, 1])
                xx, xy, xz = xx + c * (d[1] * d[1] + d[2] * d[2]), xy - c * d[0] * d[1], xz - c * d[0] * d[2]
                yy, yz = yy + c * (d[0] * d[0] + d[2] * d[2]), yz - c * d[1] * d[2]
                zz += c * (d[0] * d[0] + d[1] * d[1])
        p += ti.Vector([0.0, 0.0, 0.0, xx, xy, xz, 0.0, 0.0], ti.f64)
        q += ti.Vector([0.0, 0.0, 0.0, xy, yy, yz, 0.0, 0.0], ti.f64)
        r += ti.Vector([0.0, 0.0, 0.0, xz, yz, zz, 0.0, 0.0], ti.f64)
        for k in ti.static(range(SIX)):
            values[body, k] = [u, v, w, p, q, r][k]

    @ti.func
    def _held(self, m):
        """The block of member m: its own, and those of links that leave its body."""
        place = self.members[m]
        b, lane = self.rows.pack(place >> 4), place & 15
        held = ti.Vector([ti.cast(self.alone[c, b][lane], ti.f64) for c in ti.static(range(6))])
        for s in range(self.leaving_starts[m], self.leaving_starts[m + 1]):
            held += self._block(self._link(self.leaving[s]))
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
def _moment(n, arm):
    """n and arm × n, as a row of a block."""
    return ti.Vector(
        [
            n[0],
            n[1],
            n[2],
            arm[1] * n[2] - arm[2] * n[1],
            arm[2] * n[0] - arm[0] * n[2],
            arm[0] * n[1] - arm[1] * n[0],
            0.0,
            0.0,
        ],
        ti.f64,
    )


@ti.func
def _spread(whole, x, y, z):
    """Σ c T₁ᵀ T₂, six rows, from Σ c (1, r₂), and Σ c r₁ (1, r₂) by the components of r₁.

    T₁ᵀ T₂ is made of 1, −[r₂]×, [r₁]× and r₁·r₂ − r₂ r₁ᵀ.
    """
    turns = x[1] + y[2] + z[3]
    return [
        ti.Vector([whole[0], 0.0, 0.0, 0.0, whole[3], -whole[2], 0.0, 0.0], ti.f64),
        ti.Vector([0.0, whole[0], 0.0, -whole[3], 0.0, whole[1], 0.0, 0.0], ti.f64),
        ti.Vector([0.0, 0.0, whole[0], whole[2], -whole[1], 0.0, 0.0, 0.0], ti.f64),
        ti.Vector([0.0, -z[0], y[0], turns - x[1], -y[1], -z[1], 0.0, 0.0], ti.f64),
        ti.Vector([z[0], 0.0, -x[0], -x[2], turns - y[2], -z[2], 0.0, 0.0], ti.f64),
        ti.Vector([-y[0], x[0], 0.0, -x[3], -y[3], turns - z[3], 0.0, 0.0], ti.f64),
    ]

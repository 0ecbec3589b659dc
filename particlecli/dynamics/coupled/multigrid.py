"""A multigrid preconditioner for implicit steps: particles that springs join, together on ever coarser levels.

What a V-cycle over the coarser levels finds is added to what the particles' own blocks make of the residual: so the
finest level, where all the bytes are, is multiplied by its matrix once an iteration of conjugate gradients and not
three times, for about twice the iterations.
"""

from collections.abc import Sequence

import numpy as np
import taichi as ti
from scipy.sparse import coo_array, csr_array

from particlecli.dynamics.coupled.blocks import inverted, multiplied, product
from particlecli.dynamics.coupled.hierarchy import Coarsening, Graph, coarsenings
from particlecli.dynamics.coupled.packed_rows import PackedRows
from particlecli.dynamics.coupled.pins import Pins
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.coupled.springs import Springs
from particlecli.dynamics.group_plan import LANES

DAMPING = 2.0 / 3.0
"""ω of the steps x += ω D⁻¹ (b − A x) before and after each coarser level (Jacobi's method by blocks).

The eigenvalues of D⁻¹A are below 2.6 on coarser levels, so ω is small enough.
"""


@ti.data_oriented
class Multigrid:
    """The levels below the particles themselves, one after the other in fields of packs; all sums in a fixed order.

    Blocks xx, xy, xz, yy, yz, zz, kg, stand one after the other in `values`: of the finest level the diagonal, then
    the springs; of each coarser one likewise; and at the end one of zeros.

    Args:
        springs: the forces whose particles are gathered.
        points: all particles.
        pins: those that do not move.
        blocks: field of packs, shape (6, packs): the diagonal of the finest level.

    Attributes:
        levels: how many there are; with none there is nothing else.
        packs: in use by all of them, shape (levels + 1): where each begins, and the end.
        solution: field of packs, shape (3, packs): what was found on all levels.
    """

    def __init__(self, springs: Sequence[Springs], points: Points, pins: Pins, blocks) -> None:
        self.springs, self.points, self.blocks = list(springs), points, blocks
        self.groups = sorted({g for each in springs for g in each.groups})
        graph, free, places = self._finest(pins)
        coarser = coarsenings(graph, free)
        self.levels = len(coarser)
        if coarser:
            self._lay_out(graph, places, coarser)

    def _finest(self, pins: Pins):
        """The graph of the springs, which rows of it move, and where each spring is found, by force."""
        rows = [-(-self.points.capacities[g] // LANES) for g in self.groups]
        self.rows = np.cumsum([0, *rows]).tolist()
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

    def _lay_out(self, graph: Graph, places, coarser: list[Coarsening]) -> None:
        graphs = [graph, *(each.graph for each in coarser)]
        self.links = np.cumsum([0, *map(len, places)]).tolist()
        self.places = self._integers(np.concatenate(places))
        packs = np.cumsum([0, *(-(-each.count // LANES) for each in graphs[1:])])
        bases = np.cumsum([0, *(each.count + len(each.pairs) for each in graphs)])
        self.packs, self.bases = self._integers(packs), self._integers(bases)
        firsts = packs * LANES
        finer = [0, *(self.rows[-1] * LANES + firsts[:-1])]
        self.down = self._rows([PackedRows.of(c.down, finer[n]) for n, c in enumerate(coarser)])
        self.up = self._rows([PackedRows.of(c.prolongation, firsts[n]) for n, c in enumerate(coarser)])
        matrices = [_adjacency(each.graph, bases[n + 1]) for n, each in enumerate(coarser)]
        matrix = PackedRows.joined([PackedRows.of(m, firsts[n], bases[-1]) for n, m in enumerate(matrices)])
        self.neighbors = (self._integers(matrix.starts), self._packs(matrix.columns, ti.i32))
        self.sources = self._packs(matrix.values, ti.i32)
        self.diagonals = self._packs(_diagonals(graphs[1:], bases), ti.i32)
        self._place_sums(coarser, bases)
        pack = ti.types.vector(LANES, self.points.real)
        self.entries = ti.field(pack, shape=(6, self.sources.shape[0]))
        self.inner, self.inverses = (ti.field(pack, shape=(6, int(packs[-1]))) for _ in range(2))
        self.right, self.guess, self.solution = (ti.field(pack, shape=(3, int(packs[-1]))) for _ in range(3))
        self.rest = ti.field(pack, shape=(3, self.rows[-1] + int(packs[-1])))

    def _rows(self, parts: list[PackedRows]):
        joined = PackedRows.joined(parts)
        starts, columns = self._integers(joined.starts), self._packs(joined.columns, ti.i32)
        return starts, columns, self._packs(joined.values, self.points.real)

    def _integers(self, values):
        """A field of integers, at least one."""
        return self.points.memory.table(ti.i32, values if len(values) else np.zeros(1, np.int32))

    def _packs(self, values, real):
        """A field of packs, at least one."""
        field = ti.field(ti.types.vector(LANES, real), shape=max(1, len(values)))
        self.points.memory.view(field, values if len(values) else None)
        return field

    def _place_sums(self, coarser: list[Coarsening], bases) -> None:
        """The weights with which blocks add up to those of the next level."""
        self.values = ti.field(ti.types.vector(8, self.points.real), shape=int(bases[-1]) + 1)
        self.sums = self._integers(np.cumsum(np.concatenate([[0], *(np.diff(each.sums.indptr) for each in coarser)])))
        self.addends = self._integers(np.concatenate([each.sums.indices + bases[n] for n, each in enumerate(coarser)]))
        weights = np.concatenate([each.sums.data for each in coarser])
        self.weights = self.points.memory.table(self.points.real, weights)

    @ti.kernel
    def refresh(self):
        """Sum up the matrices of all levels from the diagonal and the springs as they are now."""
        for row in range(self.rows[-1]):
            b = self.pack(row)
            for lane in range(LANES):
                for c in ti.static(range(6)):
                    self.values[row * LANES + lane][c] = self.blocks[c, b][lane]
        for j in ti.static(range(len(self.springs))):
            for e in range(self.links[j], self.links[j + 1]):
                block = self.springs[j].block(self.places[e])
                for c in ti.static(range(6)):
                    self.values[self.rows[-1] * LANES + e][c] = block[c]
        for level in ti.static(range(1, self.levels + 1)):
            for k in range(self.bases[level], self.bases[level + 1]):
                total = 0.0 * self.values[self.bases[self.levels + 1]]
                for s in range(self.sums[k - self.bases[1]], self.sums[k - self.bases[1] + 1]):
                    total += self.weights[s] * self.values[self.addends[s]]
                self.values[k] = total
        for slot in range(self.sources.shape[0]):
            for c in range(6):
                self.entries[c, slot] = self._component(c, self.sources[slot])
        for r in range(self.diagonals.shape[0]):
            for c in range(6):
                self.inner[c, r] = self._component(c, self.diagonals[r])
            inverse = inverted([self.inner[c, r] for c in ti.static(range(6))])
            for c in ti.static(range(6)):
                self.inverses[c, r] = inverse[c]

    @ti.func
    def _component(self, c, numbers):
        """One entry of the blocks of given numbers."""
        pack = self.right[0, 0]
        for lane in range(LANES):
            pack[lane] = self.values[numbers[lane]][c]
        return pack

    @ti.func
    def pack(self, row):
        """The pack of points in a row of the finest level."""
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
    def restrict(self, r):
        """Begin a V-cycle at pack r of the first coarser level, from what is left on the finest, by row in `rest`."""
        self._set(self.right, r, self._combined(self.down, r, self.rest))
        self._set(self.guess, r, damped(product(self.inverses, r, self.right)))

    @ti.func
    def solve(self):
        """One V-cycle over all levels but the finest, once all packs of the first have begun; on one thread.

        Returns: what was found, times what was left, on the first of them.
        """
        for turn in range(2 * self.levels):
            falls = turn < self.levels
            level = turn if falls else 2 * self.levels - 1 - turn
            for r in range(self.packs[level], self.packs[level + 1]):
                if falls and level > 0:
                    self.restrict(r)
                elif level < self.levels - 1 and not falls:
                    more = self.prolonged(self.rows[-1] + r)
                    self._set(self.guess, r, [self.guess[c, r] + more[c] for c in ti.static(range(3))])
            for r in range(self.packs[level], self.packs[level + 1]):
                rest = self._rest(r)
                self._set(self.rest, self.rows[-1] + r, rest)
                better = damped(multiplied([self.inverses[c, r] for c in ti.static(range(6))], rest))
                self._set(self.solution, r, [self.guess[c, r] + better[c] for c in ti.static(range(3))])
        total = ti.cast(0.0, ti.f64)
        for r in range(self.packs[1]):
            part = 0.0 * self.right[0, r]
            for c in ti.static(range(3)):
                part += self.right[c, r] * self.solution[c, r]
            total += ti.cast(part.sum(), ti.f64)
        return total

    @ti.func
    def _set(self, field: ti.template(), r, packs):
        for c in ti.static(range(3)):
            field[c, r] = packs[c]

    @ti.func
    def _rest(self, r):
        """b − A x of a pack of a coarser level."""
        own = product(self.inner, r, self.guess)
        x, y, z = self.right[0, r] - own[0], self.right[1, r] - own[1], self.right[2, r] - own[2]
        for slot in range(self.neighbors[0][r], self.neighbors[0][r + 1]):
            qx, qy, qz = self._gathered(self.guess, self.neighbors[1][slot])
            xx, xy, xz = self.entries[0, slot], self.entries[1, slot], self.entries[2, slot]
            yy, yz, zz = self.entries[3, slot], self.entries[4, slot], self.entries[5, slot]
            x -= xx * qx + xy * qy + xz * qz
            y -= xy * qx + yy * qy + yz * qz
            z -= xz * qx + yz * qy + zz * qz
        return [x, y, z]

    @ti.func
    def prolonged(self, row):
        """What a row gets from the coarser level: of the finest level, or after all of them a pack of a coarser one."""
        return self._combined(self.up, row, self.solution)

    @ti.func
    def _combined(self, rows: ti.template(), row, field: ti.template()):
        zero = 0.0 * self.right[0, 0]
        x, y, z = zero, zero, zero
        for slot in range(rows[0][row], rows[0][row + 1]):
            qx, qy, qz = self._gathered(field, rows[1][slot])
            x, y, z = x + rows[2][slot] * qx, y + rows[2][slot] * qy, z + rows[2][slot] * qz
        return [x, y, z]

    @ti.func
    def _gathered(self, field: ti.template(), numbers):
        x, y, z = field[0, 0], field[1, 0], field[2, 0]
        for lane in range(LANES):
            pack, place = numbers[lane] >> 4, numbers[lane] & 15
            x[lane], y[lane], z[lane] = field[0, pack][place], field[1, pack][place], field[2, pack][place]
        return x, y, z


@ti.func
def damped(packs):
    """The packs of a step of Jacobi's method, as far as it goes."""
    return [DAMPING * packs[c] for c in ti.static(range(3))]


def _adjacency(graph: Graph, base: int) -> csr_array:
    """The numbers of the blocks beside the diagonal."""
    i, j = graph.pairs.T
    numbers = np.tile(base + graph.count + np.arange(len(i)), 2).astype(float)
    found: csr_array = coo_array((numbers, (np.append(i, j), np.append(j, i))), shape=(graph.count,) * 2).tocsr()
    return found


def _diagonals(graphs: list[Graph], bases):
    """The numbers of the blocks on the diagonal, shape (packs, 16)."""
    found = []
    for n, graph in enumerate(graphs):
        numbers = np.full(-(-graph.count // LANES) * LANES, bases[-1])
        numbers[: graph.count] = bases[n + 1] + np.arange(graph.count)
        found.append(numbers)
    return np.concatenate(found).reshape(-1, LANES)

"""A factor of a sparse symmetric matrix of 6×6 blocks, and what it solves; every sum in a fixed order.

A = (U + D) D⁻¹ (U + D)ᵀ, column by column; branches of the elimination tree at the same time, then its trunk. All of
it is in double precision, for there are stiff springs beside light masses.
"""

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.elimination import Elimination
from particlecli.dynamics.coupled.points import Points

SIX = 6
"""Unknowns of a block: rows and columns of it."""

WIDTH = 8
"""A row of a block is a vector of so many lanes, the last two zero."""

SMALLEST = {ti.f32: 1e-9, ti.f64: 1e-13}
"""A pivot below this share of what stood on the diagonal is rounding, by the type of the particles' numbers: what it is
of does not move. Straight chains do not feel a turn about their axis, but for rounding of places."""


@ti.data_oriented
class BlockFactor:
    """The factor, and one vector that it solves for.

    Attributes:
        values: field of rows in f64, shape (blocks, 6): the matrix, then the factor; first the blocks on the diagonal,
            then those below it by columns.
        solution: field of vectors, shape (count): the unknowns.
        branches: how many branches there are.
    """

    def __init__(self, elimination: Elimination, points: Points) -> None:
        self.smallest, integers = SMALLEST[points.real], points.memory.table
        self.count, self.blocks = elimination.count, len(elimination.rows)
        self.branches, self.trunk = len(elimination.branches) - 1, int(elimination.branches[-1])
        targets = elimination.targets()
        self.firsts = integers(ti.i32, elimination.branches)
        self.starts, self.rows = integers(ti.i32, elimination.starts), integers(ti.i32, _some(elimination.rows))
        self.row_starts = integers(ti.i32, elimination.row_starts)
        self.columns, self.places = (
            integers(ti.i32, _some(elimination.columns)),
            integers(ti.i32, _some(elimination.blocks)),
        )
        self.target_starts, self.targets = integers(ti.i32, targets[0]), integers(ti.i32, _some(targets[1]))
        wide = ti.types.vector(WIDTH, ti.f64)
        self.values = ti.field(wide, shape=(self.count + self.blocks, SIX))
        self.inverses, self.sizes = ti.field(wide, shape=(self.count, SIX)), ti.field(wide, shape=self.count)
        self.transposed = ti.field(wide, shape=(max(1, self.blocks), SIX))
        self.halfway, self.solution = ti.field(wide, shape=self.count), ti.field(wide, shape=self.count)
        self.parts = ti.field(ti.f64, shape=self.count)
        by_rows = np.empty(self.blocks, np.int64)
        by_rows[elimination.blocks] = np.arange(self.blocks)
        self.by_rows = integers(ti.i32, _some(by_rows))

    @ti.func
    def eliminate(self, j):
        """Column j of the factor, once all columns are there that its row has blocks in."""
        for r in ti.static(range(SIX)):
            self.sizes[j][r] = self.values[j, r][r]
        for f in range(self.row_starts[j], self.row_starts[j + 1]):
            k, first = self.columns[f], self.places[f]
            share = [self._weighted(k, c, f) for c in ti.static(range(SIX))]
            for t in range(self.starts[k + 1] - first):
                target = self.targets[self.target_starts[f] + t]
                for r in range(SIX):
                    row, source = self.values[target, r], self.values[self.count + first + t, r]
                    for c in ti.static(range(SIX)):
                        row -= source[c] * share[c]
                    self.values[target, r] = row
        self._invert(j)
        for e in range(self.starts[j], self.starts[j + 1]):
            for r in ti.static(range(SIX)):
                for c in ti.static(range(SIX)):
                    self.transposed[self.by_rows[e], c][r] = self.values[self.count + e, r][c]

    @ti.func
    def _weighted(self, k, c: ti.template(), f):
        """Row c of D_k⁻¹ U_jkᵀ."""
        total = self.inverses[k, c][0] * self.transposed[f, 0]
        for d in ti.static(range(1, SIX)):
            total += self.inverses[k, c][d] * self.transposed[f, d]
        return total

    @ti.func
    def _invert(self, j):
        """D_j⁻¹, with zeros for what has no pivot worth the name.

        Sweeps by every pivot lead from A to −A⁻¹ (Goodnight, Am. Stat. 33 (1979) 149).
        """
        for r in range(SIX):
            self.inverses[j, r] = self.values[j, r]
        for p in range(SIX):
            pivot = self.inverses[j, p][p]
            share = ti.select(pivot > self.smallest * self.sizes[j][p], 1.0 / pivot, ti.cast(0.0, ti.f64))
            scaled = share * self.inverses[j, p]
            for r in range(SIX):
                if r != p:
                    column = self.inverses[j, r][p]
                    self.inverses[j, r] = self.inverses[j, r] - column * scaled
                    self.inverses[j, r][p] = column * share
            self.inverses[j, p] = scaled
            self.inverses[j, p][p] = -share
        for r in range(SIX):
            self.inverses[j, r] = -self.inverses[j, r]

    @ti.func
    def descend(self, j):
        """Solve for unknowns j with those before; `halfway` has what they should give."""
        rest = self.halfway[j]
        for f in range(self.row_starts[j], self.row_starts[j + 1]):
            known = self.halfway[self.columns[f]]
            for c in ti.static(range(SIX)):
                rest -= known[c] * self.transposed[f, c]
        found = self._divided(j, rest)
        self.halfway[j] = found
        self.parts[j] = (rest * found).sum()

    @ti.func
    def ascend(self, k):
        """Solve for unknowns k with those after, once all have descended."""
        total = 0.0 * self.halfway[k]
        for e in range(self.starts[k], self.starts[k + 1]):
            known = self.solution[self.rows[e]]
            for r in ti.static(range(SIX)):
                total += known[r] * self.values[self.count + e, r]
        self.solution[k] = self.halfway[k] - self._divided(k, total)

    @ti.func
    def _divided(self, j, vector):
        """D_j⁻¹ times a vector."""
        found = vector[0] * self.inverses[j, 0]
        for d in ti.static(range(1, SIX)):
            found += vector[d] * self.inverses[j, d]
        return found

    @ti.func
    def product(self):
        """What was found times what was to be given, once all have descended."""
        total = ti.cast(0.0, ti.f64)
        for j in range(self.count):
            total += self.parts[j]
        return total


def _some(values):
    """At least one number."""
    return values if len(values) else np.zeros(1, np.int64)

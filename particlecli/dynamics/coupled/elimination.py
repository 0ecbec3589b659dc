"""The order in which the unknowns of a sparse symmetric matrix are eliminated, and the factor that this leads to.

A = (U + D) D⁻¹ (U + D)ᵀ, with D the blocks on the diagonal and U those below it. The next unknown is always one with
the fewest neighbours left (minimum degree: Tinney & Walker, Proc. IEEE 55 (1967) 1801). Set up once on the host; only
the values change.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]

BRANCH = 1 / 8
"""A branch of the elimination tree is at most this share of the work: so many threads find some."""


@dataclass(frozen=True)
class Elimination:
    """A factor by columns, and by rows; unknowns are numbered in the order in which they go.

    Branches of the elimination tree do not depend on each other, and come first; the trunk depends on all of them.

    Attributes:
        places: shape (count): the new number of each unknown.
        starts: shape (count + 1): where each column's blocks below the diagonal begin, and the end of the last.
        rows: shape (blocks): the row of each.
        row_starts: shape (count + 1): the same by rows.
        columns: shape (blocks): the columns of the blocks by rows.
        blocks: shape (blocks): their numbers among those by columns.
        branches: shape (branches + 1): the first unknown of each branch, and of the trunk.
    """

    places: Indices
    starts: Indices
    rows: Indices
    row_starts: Indices
    columns: Indices
    blocks: Indices
    branches: Indices

    @property
    def count(self) -> int:
        """Unknowns."""
        return len(self.places)

    @classmethod
    def of(cls, count: int, pairs: Indices) -> Elimination:
        """The elimination of `count` unknowns, of which pairs, shape (n, 2), have a block."""
        order, columns = _minimum_degree(count, pairs)
        places, branches = _branched(order, columns)
        rows = [np.sort(places[columns[old]]) for old in np.argsort(places)]
        starts = np.cumsum([0, *map(len, rows)])
        below = np.concatenate([np.empty(0, np.int64), *rows]).astype(np.int64)
        owners = np.repeat(np.arange(count), np.diff(starts))
        by_rows = np.lexsort((owners, below))
        row_starts = np.concatenate([[0], np.cumsum(np.bincount(below, minlength=count))]).astype(np.int64)
        return cls(places, starts, below, row_starts, owners[by_rows], by_rows, branches)

    def numbers(self) -> dict[tuple[int, int], int]:
        """The numbers of the blocks below the diagonal, by row and column."""
        owners = np.repeat(np.arange(self.count), np.diff(self.starts))
        return {pair: e for e, pair in enumerate(zip(self.rows.tolist(), owners.tolist(), strict=True))}

    def targets(self) -> tuple[Indices, Indices]:
        """Which blocks each block U_jk changes, by rows: with it U_ik for all i ≥ j of the same column change U_ij.

        Returns: where the changes of each begin, shape (blocks + 1); and of each the block that is changed, those on
        the diagonal numbered first.
        """
        numbers, rows, starts = self.numbers(), self.rows.tolist(), self.starts.tolist()
        counts, found = [0], []
        for j in range(self.count):
            for f in range(self.row_starts[j], self.row_starts[j + 1]):
                e, end = int(self.blocks[f]), starts[self.columns[f] + 1]
                found.append(j)
                found += [self.count + numbers[rows[other], j] for other in range(e + 1, end)]
                counts.append(len(found))
        return np.array(counts), np.array(found, np.int64)


def _minimum_degree(count: int, pairs: Indices) -> tuple[list[int], list[list[int]]]:
    """The order of the unknowns, and of each those still there when it goes that it has a block with by then."""
    around: list[set[int]] = [set() for _ in range(count)]
    for i, j in pairs.tolist():
        around[i].add(j)
        around[j].add(i)
    waiting = [(len(each), i) for i, each in enumerate(around)]
    heapq.heapify(waiting)
    order: list[int] = []
    gone = [False] * count
    while waiting:
        degree, i = heapq.heappop(waiting)
        if gone[i] or degree != len(around[i]):
            continue
        gone[i] = True
        order.append(i)
        for j in around[i]:
            around[j] |= around[i]
            around[j] -= {i, j}
            heapq.heappush(waiting, (len(around[j]), j))
    return order, [sorted(each) for each in around]


def _branched(order: list[int], columns: list[list[int]]) -> tuple[Indices, Indices]:
    """New numbers in which whole branches follow each other, and the first of each branch and of the trunk."""
    count = len(order)
    rank = np.empty(count, np.int64)
    rank[order] = np.arange(count)
    parents = [min(columns[i], key=rank.__getitem__) if columns[i] else -1 for i in range(count)]
    work = [float(len(each) + 1) ** 2 for each in columns]
    for i in order:
        if parents[i] >= 0:
            work[parents[i]] += work[i]
    total = sum(work[i] for i in order if parents[i] < 0)
    branch = np.full(count, count)
    for i in reversed(order):
        if work[i] <= BRANCH * total:
            branch[i] = branch[parents[i]] if parents[i] >= 0 and branch[parents[i]] < count else rank[i]
    numbered = np.lexsort((rank, branch))
    places = np.empty(count, np.int64)
    places[numbered] = np.arange(count)
    inside = branch[numbered][branch[numbered] < count]
    firsts = np.flatnonzero(np.diff(inside, prepend=-1))
    return places, np.append(firsts, len(inside))

"""Which particles that springs join make up a body, for a coarse correction of implicit steps.

What stiff springs hold together is cut in two across its longest side, and each part again (recursive coordinate
bisection: Berger & Bokhari, IEEE Trans. Comput. C-36 (1987) 570), into as many bodies as can be solved for directly.
Round bodies of equal size need fewer iterations of conjugate gradients than ones gathered from neighbour to neighbour,
on a cloth of 128 × 128 by an eighth. Set up once on the host from which particles are joined, how stiffly, and where
they are at first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from particlecli.dynamics.coupled.elimination import Elimination

Doubles = NDArray[np.float64]
Indices = NDArray[np.int64]

STRONG = 0.1
"""Links weaker than this share of the stiffest at both ends do not hold a body together."""

FEWEST = 8
"""Particles in a body, on average, are so many at least."""

FEWER = 0.75
"""Share of bodies that is tried next when all of them were too expensive."""

LINKS_A_BLOCK = 32
"""There must be so many links between particles for each block of the factor of the equations of bodies: then its
solution takes half as long as the forces of the links."""

FEW_BLOCKS = 64
"""A factor of so few blocks is cheap enough for any number of links."""


@dataclass(frozen=True)
class Graph:
    """Particles, or bodies, and what joins them.

    Attributes:
        count: particles.
        pairs: shape (n, 2): the ends of the links; some may join the same two.
        weights: shape (n,): how stiff each is, in any unit.
    """

    count: int
    pairs: Indices
    weights: Doubles

    def matrix(self) -> csr_array:
        """The symmetric matrix of the weights, links between the same two added up."""
        i, j = self.pairs.T
        both = coo_array((np.tile(self.weights, 2), (np.append(i, j), np.append(j, i))), shape=(self.count,) * 2)
        found: csr_array = both.tocsr()
        return found

    def contracted(self, owners: Indices) -> Graph:
        """The graph of what particles belong to, −1 for nothing; without links inside of it."""
        ends = owners[self.pairs]
        kept = (ends >= 0).all(axis=1) & (ends[:, 0] != ends[:, 1])
        size = int(owners.max(initial=-1)) + 1
        low, high = ends[kept].min(axis=1), ends[kept].max(axis=1)
        keys, places = np.unique(low * size + high, return_inverse=True)
        pairs = np.stack([keys // max(1, size), keys % max(1, size)], axis=1)
        weights = np.bincount(places, self.weights[kept], len(keys)).astype(float)
        return Graph(size, pairs, weights)


def bodies(graph: Graph, positions: Doubles, free: NDArray[np.bool_]) -> tuple[Indices, Elimination]:
    """The body of each particle, −1 for those that do not move or are not joined; and how to solve for all bodies.

    Bodies have the numbers in which they are eliminated.

    Args:
        graph: particles and springs.
        positions: where particles are at first, m, shape (count, 3).
        free: shape (count,): which particles move.
    """
    kept = free[graph.pairs].all(axis=1) & (graph.pairs[:, 0] != graph.pairs[:, 1])
    parts = _held_together(Graph(graph.count, graph.pairs[kept], graph.weights[kept]))
    affordable = max(FEW_BLOCKS, len(graph.pairs) // LINKS_A_BLOCK)
    wanted = sum(map(len, parts)) / FEWEST
    while True:
        owners = _cut(parts, positions, wanted)
        coarser = graph.contracted(owners)
        elimination = Elimination.of(coarser.count, coarser.pairs)
        if len(elimination.rows) <= affordable or coarser.count == len(parts):
            owners[owners >= 0] = elimination.places[owners[owners >= 0]]
            return owners, elimination
        wanted *= FEWER


def _held_together(graph: Graph) -> list[Indices]:
    """The particles of each part that strong links hold together, of those that are joined at all."""
    if not len(graph.pairs):
        return []
    links = graph.matrix()
    joined = np.flatnonzero(np.diff(links.indptr) > 0)
    labels = connected_components(_strong(links), directed=False)[1][joined]
    order = np.argsort(labels, kind="stable")
    return np.split(joined[order], np.flatnonzero(np.diff(labels[order])) + 1)


def _strong(links: csr_array) -> csr_array:
    """The links that hold bodies together."""
    strongest = np.asarray(links.max(axis=1).todense()).ravel()
    found = links.tocoo()
    kept = found.data >= STRONG * np.sqrt(strongest[found.row] * strongest[found.col])
    strong: csr_array = coo_array((found.data[kept], (found.row[kept], found.col[kept])), shape=links.shape).tocsr()
    return strong


def _cut(parts: list[Indices], positions: Doubles, wanted: float) -> Indices:
    """The body of each particle, −1 outside of all parts: about `wanted` of them, one in a part at least."""
    owners = np.full(len(positions), -1)
    size, count = sum(map(len, parts)), 0
    waiting = [(part, max(1, round(wanted * len(part) / size))) for part in reversed(parts)]
    while waiting:
        part, pieces = waiting.pop()
        if pieces == 1:
            owners[part] = count
            count += 1
            continue
        places = positions[part]
        order = part[np.argsort(places[:, np.argmax(np.ptp(places, axis=0))], kind="stable")]
        cut = round(len(part) * (pieces // 2) / pieces)
        waiting += [(order[cut:], pieces - pieces // 2), (order[:cut], pieces // 2)]
    return owners

"""Which particles that springs join make up a body, for a coarse correction of implicit steps.

Particles joined by the stiffest springs are gathered (Vaněk, Mandel & Brezina, Computing 56 (1996) 179), then bodies
are joined two by two until the equations of all of them are cheap enough to solve directly. Set up once on the host
from which particles are joined and how stiffly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from particlecli.dynamics.coupled.elimination import Elimination

Doubles = NDArray[np.float64]
Indices = NDArray[np.int64]

STRONG = 0.1
"""Links weaker than this share of the stiffest at both ends do not gather particles."""

LINKS_A_BLOCK = 16
"""There must be so many links between particles for each block of the factor of the equations of bodies: then its
solution takes about as long as the forces of the links."""

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


def bodies(graph: Graph, free: NDArray[np.bool_]) -> tuple[Indices, Elimination]:
    """The body of each particle, −1 for those that do not move or are not joined; and how to solve for all bodies.

    Bodies have the numbers in which they are eliminated.

    Args:
        graph: particles and springs.
        free: shape (count,): which particles move.
    """
    kept = free[graph.pairs].all(axis=1) & (graph.pairs[:, 0] != graph.pairs[:, 1])
    owners = _gathered(Graph(graph.count, graph.pairs[kept], graph.weights[kept]))
    affordable = max(FEW_BLOCKS, len(graph.pairs) // LINKS_A_BLOCK)
    while True:
        coarser = graph.contracted(owners)
        elimination = Elimination.of(coarser.count, coarser.pairs)
        if len(elimination.rows) <= affordable:
            found = np.full(graph.count, -1)
            found[owners >= 0] = elimination.places[owners[owners >= 0]]
            return found, elimination
        owners = np.where(owners >= 0, _matched(coarser)[owners], -1)


def _gathered(graph: Graph) -> Indices:
    """The number of each particle's body, −1 for those that are not joined; in the order of their numbers.

    First, every particle none of whose neighbours are taken gathers all of them; those left over go to the body that
    holds them most strongly.
    """
    links = graph.matrix()
    joined = np.flatnonzero(np.diff(links.indptr) > 0)
    links = _strong(links)
    starts, others, weights = links.indptr.tolist(), links.indices, links.data
    found = np.full(graph.count, -1)
    count = 0
    for i in joined.tolist():
        around = others[starts[i] : starts[i + 1]]
        if found[i] < 0 and not (found[around] >= 0).any():
            found[around] = found[i] = count
            count += 1
    first = found.copy()
    for i in joined[first[joined] < 0].tolist():
        around = slice(starts[i], starts[i + 1])
        held = first[others[around]]
        if (held >= 0).any():
            found[i] = held[np.argmax(np.where(held >= 0, weights[around], -1.0))]
        else:
            found[i], count = count, count + 1
    return found


def _strong(links: csr_array) -> csr_array:
    """The links that gather particles."""
    strongest = np.asarray(links.max(axis=1).todense()).ravel()
    found = links.tocoo()
    kept = found.data >= STRONG * np.sqrt(strongest[found.row] * strongest[found.col])
    strong: csr_array = coo_array((found.data[kept], (found.row[kept], found.col[kept])), shape=links.shape).tocsr()
    return strong


def _matched(graph: Graph) -> Indices:
    """New numbers of bodies: each takes the one that is joined to it most strongly of those that nobody has taken."""
    links = graph.matrix()
    starts, others, weights = links.indptr.tolist(), links.indices, links.data
    found = np.full(graph.count, -1)
    count = 0
    for i in range(graph.count):
        if found[i] >= 0:
            continue
        around = slice(starts[i], starts[i + 1])
        free = others[around][found[others[around]] < 0]
        if len(free):
            found[free[np.argmax(weights[around][found[others[around]] < 0])]] = count
        found[i], count = count, count + 1
    return found

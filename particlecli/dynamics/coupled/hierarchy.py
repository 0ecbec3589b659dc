"""Coarser and coarser levels of a graph of springs, for a multigrid preconditioner: which particles go together.

Set up once on the host from which particles are joined and how stiffly; only the values of the matrices change later.
Particles joined by the stiffest springs are gathered into aggregates (Vaněk, Mandel & Brezina, Computing 56 (1996)
179). A particle moves with the mean of its own aggregate and its neighbours', so that what is interpolated is smooth:
P = (I − ω D⁻¹ L) P₀, L the weighted Laplacian of the graph and P₀ the aggregates. The matrix of the next level is
Pᵀ A P, which is a sum over blocks of A with fixed weights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, dia_array

Doubles = NDArray[np.float64]
Indices = NDArray[np.int64]

SMOOTHING = 2.0 / 3.0
"""ω: how far interpolation is smoothed."""

STRONG = 0.1
"""Links weaker than this share of the stiffest at both ends do not gather particles."""

FEWEST = 1
"""A level of so few particles is the last."""

LEAST_GAIN = 0.8
"""A level with more than this share of the particles of the one before it is not worth having."""


@dataclass(frozen=True)
class Graph:
    """Particles and what joins them.

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


@dataclass(frozen=True)
class Coarsening:
    """How the blocks of a level come from those of the finer one.

    Blocks are numbered: first those on the diagonal, by particle, then one for each link.

    Attributes:
        graph: the coarser level.
        prolongation: P, shape (finer particles, coarser particles).
        sums: shape (coarser blocks, finer blocks): the weights with which finer blocks add up to coarser ones.
    """

    graph: Graph
    prolongation: csr_array
    sums: csr_array

    @property
    def down(self) -> csr_array:
        """Pᵀ."""
        return csr_array(self.prolongation.T)


def coarsenings(graph: Graph, free: NDArray[np.bool_]) -> list[Coarsening]:
    """The levels below a graph, finest first, each as long as it is worth having.

    Args:
        graph: particles and springs.
        free: shape (count,): which particles move; the others do not move on coarser levels either.
    """
    found: list[Coarsening] = []
    while graph.count > FEWEST:
        coarser = _coarsen(graph, free)
        if coarser is None:
            break
        found.append(coarser)
        graph, free = coarser.graph, np.ones(coarser.graph.count, bool)
    return found


def _coarsen(graph: Graph, free: NDArray[np.bool_]) -> Coarsening | None:
    """The next level; none where few particles would be gathered."""
    links = dia_array((free.astype(float)[None], [0]), shape=(graph.count,) * 2) @ graph.matrix()
    links = csr_array(links @ dia_array((free.astype(float)[None], [0]), shape=(graph.count,) * 2))
    links.eliminate_zeros()
    joined = np.flatnonzero(np.diff(links.indptr) > 0)
    if not len(joined):
        return None
    aggregates = _aggregates(_strong(links), joined)
    size = int(aggregates.max()) + 1
    if size > LEAST_GAIN * len(joined):
        return None
    inside = aggregates >= 0
    tentative = csr_array(
        (np.ones(inside.sum()), (np.flatnonzero(inside), aggregates[inside])), shape=(graph.count, size)
    )
    degrees = np.asarray(links.sum(axis=1)).ravel()
    share = SMOOTHING * np.divide(1.0, degrees, out=np.zeros_like(degrees), where=degrees > 0.0)
    walk = dia_array((share[None], [0]), shape=links.shape) @ links
    rest = dia_array(((1.0 - share * degrees)[None], [0]), shape=links.shape)
    prolongation = csr_array((walk + rest) @ tentative)
    prolongation.sort_indices()
    return _projected(graph, prolongation)


def _strong(links: csr_array) -> csr_array:
    """The links that gather particles."""
    strongest = np.asarray(links.max(axis=1).todense()).ravel()
    found = links.tocoo()
    kept = found.data >= STRONG * np.sqrt(strongest[found.row] * strongest[found.col])
    strong: csr_array = coo_array((found.data[kept], (found.row[kept], found.col[kept])), shape=links.shape).tocsr()
    return strong


def _aggregates(links: csr_array, joined: Indices) -> Indices:
    """The number of each particle's aggregate, −1 for those that are not joined; in the order of their numbers.

    First, every particle none of whose neighbours are taken gathers all of them; those left over go to the aggregate
    that holds them most strongly.
    """
    starts, others, weights = links.indptr.tolist(), links.indices, links.data
    found = np.full(links.shape[0], -1)
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


def _projected(graph: Graph, prolongation: csr_array) -> Coarsening:
    """The level that a prolongation leads to: blocks B_IJ = Σ P_iI P_jJ A_ij, of each pair I, J only one."""
    size = prolongation.shape[1]
    ends = np.concatenate([np.tile(np.arange(graph.count)[:, None], (1, 2)), graph.pairs])
    blocks, left, right, values = _products(prolongation, ends)
    links = blocks >= graph.count
    once = left <= right
    # A link stands for two blocks of the finer matrix, one above the diagonal and one below: P_iI P_jJ and P_jI P_iJ.
    low, high = np.where(once, left, right), np.where(once, right, left)
    values = np.where(links & (left == right), 2.0 * values, values)
    kept = links | once
    keys, rows = np.unique(low[kept] * size + high[kept], return_inverse=True)
    i, j = keys // size, keys % size
    on_diagonal = i == j
    places = np.where(on_diagonal, i, size + np.cumsum(~on_diagonal) - 1)
    pairs = np.stack([i[~on_diagonal], j[~on_diagonal]], axis=1)
    shape = (size + len(pairs), len(ends))
    sums = csr_array(coo_array((values[kept], (places[rows], blocks[kept])), shape=shape))
    degrees = np.asarray(graph.matrix().sum(axis=1)).ravel()
    weights = np.abs(sums @ np.concatenate([degrees, -graph.weights]))[size:]
    return Coarsening(Graph(size, pairs, weights), prolongation, sums)


def _products(prolongation: csr_array, ends: Indices) -> tuple[Indices, Indices, Indices, Doubles]:
    """Of each block the products of the weights of its two ends: block, both coarser particles, and product."""
    starts, lengths = prolongation.indptr[:-1], np.diff(prolongation.indptr)
    first, second = lengths[ends[:, 0]], lengths[ends[:, 1]]
    sizes = first * second
    blocks = np.repeat(np.arange(len(ends)), sizes)
    ranks = np.arange(len(blocks)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    a = starts[ends[blocks, 0]] + ranks // second[blocks]
    b = starts[ends[blocks, 1]] + ranks % second[blocks]
    columns = prolongation.indices.astype(np.int64)
    return blocks, columns[a], columns[b], prolongation.data[a] * prolongation.data[b]

"""Levels of a graph of springs: the matrices of coarser levels, and what is gathered."""

import numpy as np
import pytest
from scipy.sparse import coo_array

from particlecli.dynamics.coupled.hierarchy import Graph, coarsenings
from particlecli.dynamics.coupled.links import Lattice


def cloth(size=16):
    pairs = Lattice((size, 1, size)).pairs(("structural", "shear", "bend"))
    free = np.ones(size * size, bool)
    free[[0, size - 1]] = False
    return Graph(size * size, pairs, np.full(len(pairs), 3.0)), free


def matrix(graph, blocks):
    """The symmetric matrix of blocks of one number, first the diagonal, then of each link."""
    i, j = graph.pairs.T
    own = np.arange(graph.count)
    places = (np.concatenate([own, i, j]), np.concatenate([own, j, i]))
    return coo_array((np.append(blocks, blocks[graph.count :]), places), shape=(graph.count,) * 2).toarray()


def test_blocks_add_up_to_the_projected_matrix():
    graph, free = cloth()
    blocks = np.random.default_rng(0).normal(size=graph.count + len(graph.pairs))
    levels = coarsenings(graph, free)
    assert len(levels) >= 2
    for level in levels:
        finer, p = matrix(graph, blocks), level.prolongation.toarray()
        blocks, graph = level.sums @ blocks, level.graph
        np.testing.assert_allclose(matrix(graph, blocks), p.T @ finer @ p, atol=1e-12)


def test_pinned_particles_stay_and_the_others_move_with_a_mean():
    graph, free = cloth()
    shares = coarsenings(graph, free)[0].prolongation.sum(axis=1)
    np.testing.assert_allclose(shares[~free], 0.0)
    np.testing.assert_allclose(shares[free], 1.0)


@pytest.mark.parametrize("count", [2, 7, 40])
def test_each_of_many_chains_ends_as_one(count):
    links = np.arange(count - 1)[:, None] + [0, 1]
    pairs = np.concatenate([links + count * strand for strand in range(30)])
    levels = coarsenings(Graph(30 * count, pairs, np.ones(len(pairs))), np.ones(30 * count, bool))
    assert levels[-1].graph.count == 30
    assert not len(levels[-1].graph.pairs)


def test_nothing_is_gathered_without_springs():
    assert coarsenings(Graph(32, np.empty((0, 2), np.int64), np.empty(0)), np.ones(32, bool)) == []

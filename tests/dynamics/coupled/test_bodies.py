"""Bodies of a graph of springs: what is gathered, and how cheap their equations are."""

import numpy as np
import pytest

from particlecli.dynamics.coupled.bodies import FEW_BLOCKS, LINKS_A_BLOCK, Graph, bodies
from particlecli.dynamics.coupled.links import Lattice


def cloth(size):
    pairs = Lattice((size, 1, size)).pairs(("structural", "shear", "bend"))
    free = np.ones(size * size, bool)
    free[[0, size - 1]] = False
    own = np.arange(size * size)
    return Graph(size * size, pairs, np.full(len(pairs), 3.0)), np.stack([own % size, 0 * own, own // size], 1), free


def test_bodies_are_joined_parts_of_a_cloth_that_move_and_few_enough():
    graph, positions, free = cloth(64)
    owners, elimination = bodies(graph, positions.astype(float), free)
    np.testing.assert_array_equal(owners >= 0, free)
    sizes = np.bincount(owners[free])
    assert sizes.max() <= sizes.min() + 1
    # As round as squares are: no side is more than twice the other.
    for body in range(0, elimination.count, 10):
        wide, long = np.sort(np.ptp(positions[owners == body][:, [0, 2]], axis=0) + 1)
        assert long <= 2 * wide
    assert elimination.count == owners.max() + 1
    assert len(elimination.rows) <= len(graph.pairs) / LINKS_A_BLOCK
    # Of each body the particles hang together: it is one piece of the graph of the links inside of it.
    inside = graph.pairs[owners[graph.pairs[:, 0]] == owners[graph.pairs[:, 1]]]
    pieces = np.arange(graph.count)
    for _ in range(graph.count):
        low = pieces[inside].min(axis=1)
        before = pieces.copy()
        np.minimum.at(pieces, inside, low[:, None])
        if (pieces == before).all():
            break
    assert len(np.unique(pieces[free])) == elimination.count


@pytest.mark.parametrize("count", [0, 5])
def test_without_springs_there_are_no_bodies(count):
    alone = Graph(count, np.empty((0, 2), np.int64), np.empty(0))
    owners, elimination = bodies(alone, np.zeros((count, 3)), np.ones(count, bool))
    assert elimination.count == 0
    assert (owners == -1).all()


@pytest.mark.parametrize("count", [2, 7, 40])
def test_chains_do_not_share_bodies(count):
    links = np.arange(count - 1)[:, None] + [0, 1]
    pairs = np.concatenate([links + count * strand for strand in range(30)])
    graph, positions = Graph(30 * count, pairs, np.ones(len(pairs))), np.zeros((30 * count, 3))
    owners, _ = bodies(graph, positions, np.ones(30 * count, bool))
    strands = np.repeat(np.arange(30), count)
    for body in range(owners.max() + 1):
        assert len(np.unique(strands[owners == body])) == 1


@pytest.mark.parametrize("strands", [30, 100, 1000])
@pytest.mark.parametrize("count", [9, 16, 25])
def test_many_chains_have_as_few_bodies_as_are_affordable_or_one_each(strands, count):
    links = np.arange(count - 1)[:, None] + [0, 1]
    pairs = np.concatenate([links + count * strand for strand in range(strands)])
    size = strands * count
    positions = np.stack([np.arange(size) % count, 0 * np.arange(size), 0 * np.arange(size)], 1).astype(float)
    _, elimination = bodies(Graph(size, pairs, np.ones(len(pairs))), positions, np.ones(size, bool))
    assert elimination.count == strands or len(elimination.rows) <= max(FEW_BLOCKS, len(pairs) // LINKS_A_BLOCK)


@pytest.mark.parametrize("pairs", [np.empty((0, 2), np.int64), np.array([[0, 1]])])
def test_nothing_is_gathered_without_springs_between_particles_that_move(pairs):
    free = np.arange(32) > 0
    owners, elimination = bodies(Graph(32, pairs, np.ones(len(pairs))), np.zeros((32, 3)), free)
    assert elimination.count == 0
    assert (owners == -1).all()

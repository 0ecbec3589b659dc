"""Links of lattices, and the table that has each of them twice."""

import numpy as np
import pytest

from particlecli.dynamics.coupled.links import APART, Adjacency, Lattice

ALL = ("structural", "shear", "bend")


@pytest.mark.parametrize(
    ("counts", "numbers"),
    [
        ((5, 1, 1), (4, 0, 3)),
        ((4, 3, 1), (9 + 8, 2 * 6, 6 + 4)),
        ((3, 3, 3), (3 * 18, 3 * 2 * 4 * 3 + 4 * 8, 3 * 9)),
    ],
)
def test_lattices_have_as_many_links_as_counted_by_hand(counts, numbers):
    places = np.stack(np.unravel_index(np.arange(np.prod(counts)), counts, order="F"), axis=1)
    for kind, number in zip(ALL, numbers, strict=True):
        pairs = Lattice(counts).pairs([kind])
        steps = np.abs(places[pairs[:, 1]] - places[pairs[:, 0]])
        assert len({frozenset(pair) for pair in pairs.tolist()}) == len(pairs) == number
        size = {"structural": (1, 1), "shear": (1, 3), "bend": (2, 2)}[kind]
        assert (steps.max(axis=1, initial=0) == size[0]).all()
        assert (steps.sum(axis=1) <= size[1]).all()
        assert (steps.sum(axis=1) > 1).all() == (kind != "structural" or not number)


def test_strands_of_hair_are_not_linked_with_each_other():
    pairs = Lattice((4, 3, 1), (True, False, False)).pairs(ALL)
    assert (pairs[:, 0] // 4 == pairs[:, 1] // 4).all()
    assert len(pairs) == 3 * (3 + 2)


def test_a_body_runs_along_its_longest_side():
    lattice = Lattice((3, 1, 5))
    s, side = lattice.places()
    behind, ahead = lattice.neighbours()
    np.testing.assert_allclose(s, np.repeat(np.arange(5) / 4, 3))
    np.testing.assert_allclose(side, np.tile([-1, 0, 1], 5))
    assert (behind[0], ahead[0], behind[7], ahead[7], ahead[14]) == (0, 3, 4, 10, 14)


def test_every_link_is_in_the_table_of_both_its_ends():
    random = np.random.default_rng(0)
    pairs = np.array([(a, b) for a in range(40) for b in range(a) if random.random() < 0.1])
    table = Adjacency.of(pairs, 40)
    found = set()
    for pack in range(3):
        for slot in range(table.starts[pack], table.starts[pack + 1]):
            for lane in range(16):
                if table.links[slot, lane] >= 0:
                    found.add((16 * pack + lane, table.partners[slot, lane], table.links[slot, lane]))
                else:
                    assert table.partners[slot, lane] == 16 * pack + lane
    right = {(a, b, n) for n, (a, b) in enumerate(pairs)} | {(b, a, n) for n, (a, b) in enumerate(pairs)}
    assert found == right


def test_links_of_a_lattice_that_lead_equally_far_share_slots_and_cost_none():
    lattice = Lattice((40, 1, 7))
    table = Adjacency.of(lattice.pairs(ALL), 280)
    steps = table.steps()
    assert set(steps) <= {1, 2, 39, 40, 41, 80, -1, -2, -39, -40, -41, -80, APART}
    assert (steps != APART).mean() > 0.8
    degrees = np.bincount(lattice.pairs(ALL).ravel(), minlength=18 * 16)
    np.testing.assert_array_equal(np.diff(table.starts), degrees.reshape(-1, 16).max(axis=1))


def test_links_between_the_same_two_have_a_slot_each():
    table = Adjacency.of(np.array([[0, 1], [0, 1], [2, 3]]), 4)
    np.testing.assert_array_equal(table.links[table.partners == 0], [0, 1])
    assert table.starts[-1] >= 2

"""The order in which unknowns are eliminated: its factor has a place for every block, and its branches are apart."""

import numpy as np

from particlecli.dynamics.coupled.elimination import BRANCH, Elimination


def grid(size):
    numbers = np.arange(size * size).reshape(size, size)
    ends = [(numbers[:, 1:], numbers[:, :-1]), (numbers[1:], numbers[:-1]), (numbers[1:, 1:], numbers[:-1, :-1])]
    return np.concatenate([np.stack([a.ravel(), b.ravel()], axis=1) for a, b in ends])


def factored(elimination, matrix):
    """The blocks, of one number, that the kernels would find, by the lists that they go through."""
    values = {(i, i): matrix[i, i] for i in range(elimination.count)}
    numbers = elimination.numbers()
    values |= {pair: matrix[pair] for pair in numbers}
    pairs = list(numbers)
    starts, targets = elimination.targets()
    for j in range(elimination.count):
        for f in range(elimination.row_starts[j], elimination.row_starts[j + 1]):
            k, first = elimination.columns[f], elimination.blocks[f]
            share = values[j, k] / values[k, k]
            for t, target in enumerate(targets[starts[f] : starts[f + 1]]):
                place = (j, j) if target < elimination.count else pairs[target - elimination.count]
                values[place] -= values[elimination.rows[first + t], k] * share
    return values


def test_the_factor_multiplies_to_the_matrix():
    pairs = grid(9)
    elimination = Elimination.of(81, pairs)
    rng = np.random.default_rng(1)
    matrix = np.diag(rng.uniform(10, 12, 81))
    i, j = elimination.places[pairs].T
    matrix[i, j] = matrix[j, i] = rng.uniform(-1, 1, len(pairs))
    values = factored(elimination, matrix)
    lower = np.zeros((81, 81))
    for place, value in values.items():
        lower[place] = value
    np.testing.assert_allclose(lower / np.diag(lower) @ lower.T, matrix, atol=1e-12)


def test_a_grid_fills_up_less_than_half_as_much_as_in_the_order_of_its_rows():
    assert len(Elimination.of(1024, grid(32)).rows) < 0.5 * 1024 * 33


def test_branches_do_not_touch_each_other_and_leave_a_small_trunk():
    elimination = Elimination.of(1024, grid(32))
    owners = np.repeat(np.arange(1024), np.diff(elimination.starts))
    trunk = elimination.branches[-1]
    branch = np.searchsorted(elimination.branches, np.arange(1024), side="right")
    same = (branch[owners] == branch[elimination.rows]) | (elimination.rows >= trunk)
    assert same.all()
    assert len(elimination.branches) > 1 / BRANCH / 2
    assert trunk > 0.7 * 1024

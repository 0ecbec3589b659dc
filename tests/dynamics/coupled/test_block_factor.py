"""A sparse matrix of 6×6 blocks is factorized and solved for, also where it is singular."""

import numpy as np
import pytest
import taichi as ti

from particlecli import runtime
from particlecli.dynamics.coupled.block_factor import SIX, WIDTH, BlockFactor
from particlecli.dynamics.coupled.elimination import Elimination
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.memory import FieldMemory
from tests.dynamics.coupled.test_elimination import grid

STILL = 7
"""A body one of whose motions nothing resists."""


@ti.data_oriented
class Solver:
    def __init__(self, factor):
        self.factor = factor

    @ti.kernel
    def factorize(self):
        ti.loop_config(serialize=True)
        for j in range(self.factor.count):
            self.factor.eliminate(j)

    @ti.kernel
    def solve(self, right: ti.types.ndarray(dtype=ti.f64, ndim=2), product: ti.types.ndarray(dtype=ti.f64, ndim=1)):
        ti.loop_config(serialize=True)
        for j in range(self.factor.count):
            given = 0.0 * self.factor.halfway[j]
            for c in range(SIX):
                given[c] = right[j, c]
            self.factor.descend(j, given)
        ti.loop_config(serialize=True)
        for k in range(self.factor.count):
            self.factor.ascend(self.factor.count - 1 - k)
        product[0] = self.factor.product()


def laid_out(elimination, matrix):
    """The blocks of a matrix in the order in which the factor has them."""
    places = [(i, i) for i in range(elimination.count)] + list(elimination.numbers())
    values = np.zeros((len(places), SIX, WIDTH))
    for value, (i, j) in zip(values, places, strict=True):
        value[:, :SIX] = matrix[SIX * i : SIX * i + SIX, SIX * j : SIX * j + SIX]
    return values


@pytest.mark.slow
def test_the_solution_solves_and_what_nothing_resists_stays_still():
    runtime.start("double", 2)
    rng = np.random.default_rng(3)
    elimination = Elimination.of(25, grid(5))
    # A sum of stretched links: positive definite but for one motion of one body.
    matrix = np.diag(rng.uniform(1, 2, 25 * SIX))
    for i, j in elimination.places[grid(5)]:
        link = np.zeros((SIX, 25 * SIX))
        link[:, SIX * i : SIX * i + SIX], link[:, SIX * j : SIX * j + SIX] = rng.normal(size=(2, SIX, SIX))
        matrix += link.T @ link
    still = SIX * STILL + 4
    matrix[still], matrix[:, still] = 0.0, 0.0
    memory = FieldMemory()
    factor = BlockFactor(elimination, Points({"any": 16}, ti.f64, memory))
    values, solution = memory.view(factor.values), memory.view(factor.solution)
    values.array[...] = laid_out(elimination, matrix)
    solver, product, right = Solver(factor), np.zeros(1), rng.normal(size=(25, SIX))
    solver.factorize()
    solver.solve(right, product)
    found = solution.array[:25, :SIX].ravel()
    moves = np.arange(25 * SIX) != still
    expected = np.zeros(25 * SIX)
    expected[moves] = np.linalg.solve(matrix[np.ix_(moves, moves)], right.ravel()[moves])
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert product[0] == pytest.approx(expected @ right.ravel())

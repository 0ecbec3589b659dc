"""Where a force has a potential, the force is its downward slope."""

import numpy as np
import pytest

from particlecli.dynamics.forces import force_term
from tests.dynamics.forces.references import CASES, norm, some_points
from tests.dynamics.harness import Points, acceleration, potential, rounded

CONSERVATIVE = [case for case in CASES if force_term(case.spec).has_potential]
STEP = 1e-4


def slope(spec, points):
    """−∇ of the potential by central differences of fourth order."""

    def at(way, steps):
        x = points.x + steps * STEP * way[:, None]
        return potential("double", spec, Points(x, points.v, points.u, points.t, points.inverse_mass))

    return np.stack([-(8 * (at(e, 1) - at(e, -1)) - (at(e, 2) - at(e, -2))) / (12 * STEP) for e in np.eye(3)])


def away_from_the_middle():
    """Points where second differences of any potential here are small enough to trust."""
    points = some_points()
    far = norm(points.x) > 0.7
    return Points(*(part[..., far] for part in vars(points).values()))


def share_that_agrees(a, b):
    return np.mean(norm(a - b) < 1e-7 * (norm(a) + 1))


@pytest.mark.parametrize("case", CONSERVATIVE, ids=lambda case: case.label)
def test_the_force_is_the_downward_slope_of_the_potential(case):
    points = away_from_the_middle()
    found = acceleration("double", case.spec, points)
    downward = slope(case.spec, points)
    # The few points whose differences reach over a cutoff are left out.
    assert share_that_agrees(found, downward) > 0.995
    assert share_that_agrees(found, 0.999 * downward) < 0.5
    assert share_that_agrees(found, -downward) < 0.5


@pytest.fixture(scope="module")
def energies():
    """Potentials of all cases, one precision after the other, as each change starts Taichi anew."""
    points = some_points().rounded("single")
    return {
        precision: {case.label: potential(precision, case.spec, points) for case in CONSERVATIVE}
        for precision in ("single", "double")
    }


@pytest.mark.slow
@pytest.mark.parametrize("case", CONSERVATIVE, ids=lambda case: case.label)
def test_potentials_in_single_precision_agree_with_double(energies, case):
    single, double = energies["single"][case.label], energies["double"][case.label]
    np.testing.assert_allclose(single, double, rtol=1e-5, atol=2e-6 * np.abs(double).max())


def test_the_potentials_are_those_of_the_forces_that_conserve_energy():
    types = {case.type for case in CONSERVATIVE}
    assert types == {"gravity", "point_gravity", "force_field", "orbit", "vortex"}
    for case in CASES:
        rotates = case.type == "vortex" and case.numbers["swirl"] != 0
        forced = "force" in case.written
        assert force_term(case.spec).has_potential == (case.type in types and not rotates and not forced)


def test_a_point_mass_has_no_potential_far_away():
    x = rounded(np.array([[1e6], [0.0], [0.0]]), "double")
    still = Points(x, 0 * x, 0 * x, x[0], x[0])
    case = next(case for case in CASES if case.type == "point_gravity")
    assert potential("double", case.spec, still)[0] == pytest.approx(-1.7e-6)

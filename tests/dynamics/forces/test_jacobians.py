"""The Jacobian of every force is the slope of its formula."""

import numpy as np
import pytest

from tests.dynamics.forces.references import CASES, norm, some_points
from tests.dynamics.harness import Points, jacobian

STEP = 1e-3


def away_from_the_middle():
    """Points where differences of any force here are small enough to trust."""
    points = some_points().rounded("single")
    far = (norm(points.x) > 0.7) & (norm(points.u - points.v) > 0.3)
    return Points(*(part[..., far] for part in vars(points).values()))


POINTS = away_from_the_middle()
GRADIENT = np.random.default_rng(41).uniform(-2, 2, (3, 3, POINTS.t.size)).astype(np.float32).astype(float)
"""Of the flow: its velocity at a point nearby is u + gradient · offset."""


def slopes(case):
    """∂a/∂x and ∂a/∂v of a force's formula by central differences of fourth order: two arrays (3, 3, n)."""

    def at(way, in_velocity, steps):
        offset = steps * STEP * way[:, None]
        x, v, u = POINTS.x, POINTS.v, POINTS.u
        if in_velocity:
            v = v + offset
        else:
            x, u = x + offset, u + np.einsum("ijn,jk->in", GRADIENT, offset)
        moved = Points(x, v, u, POINTS.t, POINTS.inverse_mass)
        return np.asarray(case.reference(moved, **case.numbers))

    def slope(way, kind):
        return (8 * (at(way, kind, 1) - at(way, kind, -1)) - (at(way, kind, 2) - at(way, kind, -2))) / (12 * STEP)

    return np.stack([np.stack([slope(way, kind) for way in np.eye(3)], axis=1) for kind in (False, True)])


def share_that_agrees(a, b, tolerance):
    """The share of points at which two pairs of matrices agree."""
    size = np.abs(b).max(axis=(1, 2))
    return np.mean((np.abs(a - b).max(axis=(1, 2)) <= tolerance * (size + 1e-3)).all(axis=0))


@pytest.fixture(scope="module")
def found():
    """Jacobians of all cases in double precision."""
    return {case.label: jacobian("double", case.spec, POINTS, GRADIENT) for case in CASES}


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.label)
def test_the_jacobian_is_the_slope_of_the_acceleration(found, case):
    right = slopes(case)
    # The few points whose differences reach over a cutoff are left out.
    assert share_that_agrees(found[case.label], right, 2e-6) > 0.99
    for part in (0, 1):
        if np.any(right[part]):
            for factor in (0.999, -1):
                wrong = right.copy()
                wrong[part] *= factor
                assert share_that_agrees(found[case.label], wrong, 2e-6) < 0.3


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.label)
def test_jacobians_in_single_precision_agree_with_double(found, case):
    single = jacobian("single", case.spec, POINTS, GRADIENT)
    assert share_that_agrees(single, found[case.label], 3e-5) > 0.995


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.label)
def test_a_force_without_velocity_has_no_jacobian_by_it(found, case):
    assert np.any(found[case.label][1]) == case.spec.depends_on_velocity


@pytest.mark.parametrize("case", [case for case in CASES if "cutoff" in case.numbers], ids=lambda c: c.label)
def test_within_a_cutoff_the_jacobian_vanishes(case):
    zeros = np.zeros((3, 16))
    middle = Points(zeros, zeros, zeros, zeros[0], zeros[0] + 1)
    assert not jacobian("double", case.spec, middle, np.zeros((3, 3, 16))).any()

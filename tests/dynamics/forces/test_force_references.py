"""Forces against their formulas; each formula with one number wrong must fail."""

import typing

import numpy as np
import pytest

from particlecli.dynamics.forces import ForceTerm, force_term
from particlecli.scene import forces as scene
from tests.dynamics.forces.references import CASES, norm, some_points, spec
from tests.dynamics.harness import EPSILON, Points, acceleration


@pytest.fixture(scope="module", params=["single", "double"])
def precision(request):
    return request.param


def close(found, right, precision):
    """The share of points whose acceleration is right to within rounding."""
    return np.mean(norm(found - right) <= 60 * EPSILON[precision] * norm(right))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.label)
def test_acceleration_is_what_the_formula_says(precision, case):
    points = some_points().rounded(precision)
    found = acceleration(precision, case.spec, points)
    # Next to a cutoff or a point where two large terms cancel a rounding may decide.
    assert close(found, case.reference(points, **case.numbers), precision) > 0.995


def changes(key):
    """Factors that make a number wrong; the sign of a length means nothing."""
    lengths = {"softening": (0.5, 1.001), "core": (0.5, 1.001), "cutoff": (0.5, 1.1)}
    return lengths.get(key, (0.5, -1.0, 1.001))


NUMBERS = [
    (case, key, factor)
    for case in CASES
    for key, value in case.numbers.items()
    if key not in {"flow", "axis"} and np.any(value)
    for factor in changes(key)
]


@pytest.fixture(scope="module")
def found():
    points = some_points()
    return {case.label: acceleration("double", case.spec, points) for case in CASES}


@pytest.mark.parametrize(("case", "key", "factor"), NUMBERS, ids=lambda part: getattr(part, "label", str(part)))
def test_a_formula_with_one_number_wrong_does_not_match(found, case, key, factor):
    value = case.numbers[key]
    wrong = {**case.numbers, key: tuple(factor * c for c in value) if np.ndim(value) else factor * value}
    matching = close(found[case.label], case.reference(some_points(), **wrong), "double")
    assert matching < (0.98 if key == "cutoff" else 0.7)


def test_a_drag_without_its_flow_does_not_match(found):
    for case in CASES:
        if "flow" in case.numbers:
            still = case.reference(some_points(), **{**case.numbers, "flow": None})
            assert close(found[case.label], still, "double") < 0.1


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.label)
def test_a_force_says_whether_it_depends_on_velocity(found, case):
    points = some_points()
    faster = acceleration("double", case.spec, Points(points.x, points.v + 1, points.u, points.t, points.inverse_mass))
    assert np.array_equal(faster, found[case.label]) != force_term(case.spec).depends_on_velocity


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.label)
def test_a_force_says_whether_it_depends_on_mass(found, case):
    points = some_points()
    lighter = acceleration("double", case.spec, Points(points.x, points.v, points.u, points.t, 2 * points.inverse_mass))
    assert np.array_equal(lighter, found[case.label]) != case.spec.uses_mass


@pytest.mark.parametrize(
    "parts",
    [
        {"type": "point_gravity", "strength": 2.0, "cutoff": 0.1},
        {"type": "point_gravity", "strength": 2.0, "softening": 0.1},
        {"type": "vortex", "swirl": 1.0, "pull": 1.0},
        {"type": "orbit", "strength": 1.0, "exponent": 2.0},
    ],
    ids=lambda parts: "-".join(map(str, parts.values())),
)
def test_in_its_very_middle_a_guarded_force_vanishes(precision, parts):
    zeros = np.zeros((3, 16))
    middle = Points(zeros, zeros, zeros, zeros[0], zeros[0] + 1)
    assert not acceleration(precision, spec(**parts), middle).any()


def test_an_attraction_is_right_over_six_decades(precision):
    size = np.geomspace(1e-3, 1e3, 500)
    x = size * np.array([[0.6], [0.0], [-0.8]])
    points = Points(x, 0 * x, 0 * x, 0 * size, 1 + 0 * size).rounded(precision)
    found = acceleration(precision, spec(type="point_gravity", strength=2.0), points)
    np.testing.assert_allclose(norm(found), 2 / norm(points.x) ** 2, rtol=20 * EPSILON[precision])


def test_every_force_on_particles_alone_has_its_term_and_its_reference():
    kinds = typing.get_args(scene.UnaryForce)
    assert {type(case.spec) for case in CASES} == set(kinds)
    terms = {type(case.spec): type(force_term(case.spec)) for case in CASES}
    assert len(set(terms.values())) == len(kinds)
    assert all(issubclass(term, ForceTerm) for term in terms.values())

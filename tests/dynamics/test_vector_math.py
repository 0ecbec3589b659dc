"""Elementary functions on packs against NumPy's in extended precision, in both precisions."""

import math

import numpy as np
import pytest
import taichi as ti

from particlecli.dynamics import vector_math
from tests.dynamics.harness import numpy_type, on_packs

COUNT = 40_000
RANDOM = np.random.default_rng(20)
LARGE = {"single": 1e4, "double": 1e5}
TINY = {"single": 1e-37, "double": 1e-300}
EXPONENT = {"single": 87.0, "double": 700.0}


@pytest.fixture(scope="module", params=["single", "double"])
def precision(request):
    return request.param


def evenly(low, high):
    return RANDOM.uniform(low, high, COUNT)


def over_magnitudes(low, high):
    return np.exp(evenly(math.log(low), math.log(high)))


def worst_ulps(precision, function, reference, *columns):
    """Largest error in units in the last place of the right result."""
    kind = numpy_type(precision)
    columns = [column.astype(kind) for column in columns]
    found = on_packs(precision, lambda p, *packs: (function(*packs),), *columns)[0]
    right = reference(*(column.astype(np.longdouble) for column in columns))
    # Not np.spacing: that may be a subnormal number, which counts as zero while Taichi is loaded.
    unit = np.ldexp(np.longdouble(1), np.frexp(right)[1] - np.finfo(kind).nmant - 1)
    return float(np.max(np.abs(found - right) / unit))


@pytest.mark.parametrize("name", ["sin", "cos", "tan"])
@pytest.mark.parametrize("reach", [3.0, None], ids=["near", "far"])
def test_trigonometric_functions_are_right_far_from_the_origin_too(precision, name, reach):
    reach = reach or LARGE[precision]
    limit = 5.0 if name == "tan" else 2.5
    assert worst_ulps(precision, getattr(vector_math, name), getattr(np, name), evenly(-reach, reach)) < limit


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sine_and_cosine_are_right_next_to_their_zeros(precision, name):
    zeros = np.pi * (np.arange(1, COUNT) + (0.5 if name == "cos" else 0.0))
    near = zeros[zeros < LARGE[precision]]
    assert worst_ulps(precision, getattr(vector_math, name), getattr(np, name), near) < 2.5


def test_exponential(precision):
    reach = EXPONENT[precision]
    assert worst_ulps(precision, vector_math.exp, np.exp, evenly(-reach, reach)) < 1.5
    assert worst_ulps(precision, vector_math.exp, np.exp, evenly(-1, 1)) < 1.5


def test_logarithm(precision):
    tiny = TINY[precision]
    assert worst_ulps(precision, vector_math.log, np.log, over_magnitudes(tiny, 1 / tiny)) < 1.0
    assert worst_ulps(precision, vector_math.log, np.log, evenly(0.5, 2)) < 1.0


def test_mean_decay_has_no_cancellation(precision):
    def reference(s):
        return -np.expm1(-s) / s

    assert worst_ulps(precision, vector_math.mean_decay, reference, over_magnitudes(1e-12, 80)) < 2.0


def test_cosine_of_turns(precision):
    turns = evenly(-30, 30).astype(numpy_type(precision))
    found = on_packs(precision, lambda p, x: (vector_math.cos_turns(x),), turns)[0]
    tau = 8 * np.arctan(np.longdouble(1))
    right = np.cos(tau * (turns - np.round(turns)).astype(np.longdouble))
    assert np.max(np.abs(found - right)) < {"single": 3e-7, "double": 5e-16}[precision]


def test_power(precision):
    base, exponent = over_magnitudes(1e-6, 1e6), evenly(-2.5, 2.5)
    # In double precision the error grows with the logarithm of the result, here up to 35.
    limit = {"single": 1.0, "double": 40.0}[precision]
    assert worst_ulps(precision, vector_math.pow, np.power, base, exponent) < limit


def test_a_constant_exponent_keeps_its_digits_in_single_precision():
    base = over_magnitudes(1e-6, 1e6)
    assert worst_ulps("single", lambda x: vector_math.pow(x, 1.7), lambda x: x**1.7, base) < 1.0
    assert worst_ulps("single", lambda x: vector_math.pow(1.7, x), lambda x: 1.7**x, evenly(-99, 99)) < 1.0


INF, NAN = math.inf, math.nan


@pytest.mark.parametrize(
    ("name", "arguments", "values"),
    [
        ("sin", [INF, -INF, NAN, 0.0], [NAN, NAN, NAN, 0.0]),
        ("cos", [INF, -INF, NAN, 0.0], [NAN, NAN, NAN, 1.0]),
        ("tan", [INF, -INF, NAN, 0.0], [NAN, NAN, NAN, 0.0]),
        ("cos_turns", [INF, -INF, NAN, 0.0], [NAN, NAN, NAN, 1.0]),
        ("exp", [INF, -INF, NAN, 0.0, 1e4, -1e4], [INF, 0.0, NAN, 1.0, INF, 0.0]),
        ("log", [INF, -INF, NAN, 0.0, -0.0, -1.0, 1.0], [INF, NAN, NAN, -INF, -INF, NAN, 0.0]),
        ("mean_decay", [INF, NAN, 0.0], [0.0, NAN, 1.0]),
    ],
)
def test_ends_of_the_number_line(precision, name, arguments, values):
    function = getattr(vector_math, name)
    found = on_packs(precision, lambda p, x: (function(x),), np.array(arguments))[0]
    np.testing.assert_allclose(found, values, rtol=1e-6, atol=1e-7)


def test_power_at_zero_and_for_negative_bases(precision):
    base = np.array([0.0, 0.0, 0.0, -2.0, -2.0, -2.0, 2.0, NAN, 3.0])
    exponent = np.array([2.5, 0.0, -1.0, 3.0, 2.0, 0.5, 0.0, 2.0, NAN])
    found = on_packs(precision, lambda p, x, y: (vector_math.pow(x, y),), base, exponent)[0]
    np.testing.assert_allclose(found, [0.0, 1.0, INF, -8.0, 4.0, NAN, 1.0, NAN, NAN], rtol=1e-6)


def test_sine_stays_bounded_where_numbers_are_too_coarse_for_it(precision):
    huge = over_magnitudes(1e8, 1e30)
    found = on_packs(precision, lambda p, x: (vector_math.sin(x), vector_math.cos(x)), huge, outputs=2)
    assert np.all(np.abs(found) <= 1)


@pytest.mark.parametrize(("name", "reference"), [("minimum", np.minimum), ("maximum", np.maximum), ("clip", np.clip)])
def test_bounds_follow_numpy_for_undefined_numbers_too(precision, name, reference):
    values = np.array([-1.5, 2.5, NAN, INF, -INF, 0.3])
    columns = np.array(np.meshgrid(*[values] * (3 if name == "clip" else 2))).reshape(-1, 36 if name != "clip" else 216)
    function = getattr(vector_math, name)
    found = on_packs(precision, lambda p, *packs: (function(*packs),), *columns)[0]
    np.testing.assert_allclose(found, reference(*columns), rtol=1e-6)


@pytest.mark.parametrize("name", ["sin", "exp", "log", "mean_decay", "cos_turns"])
def test_single_packs_stay_single_in_a_double_run(name):
    types = []

    def function(_, x):
        result = getattr(vector_math, name)(ti.cast(x, ti.f32))
        types.append(result.element_type())
        return (result,)

    on_packs("double", function, np.array([0.5]))
    assert types == [ti.f32]


def test_scalars_are_welcome(precision):
    found = on_packs(
        precision,
        lambda p, x: (vector_math.sin(p[0]), vector_math.exp(p[0])),
        np.zeros(3),
        outputs=2,
        parameters=[0.7],
    )
    np.testing.assert_allclose(found[:, 0], [np.sin(0.7), np.exp(0.7)], rtol=3e-7)

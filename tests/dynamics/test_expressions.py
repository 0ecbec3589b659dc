"""Expressions mean the same on packs as in NumPy."""

import numpy as np
import pytest

from particlecli.dynamics.expressions import PACK_FUNCTIONS, evaluate
from particlecli.scene.expression import FUNCTION_NAMES, NUMPY_FUNCTIONS, Expression
from tests.dynamics.harness import on_packs, rounded

NAMES = "xyzt"
RANDOM = np.random.default_rng(21)
VALUES = RANDOM.uniform(-2, 2, (4, 500))

SOURCES = [
    "2*x + 3*y - z/4",
    "-x**2 + y**3 - z**-2",
    "abs(x)**1.5 + abs(y)**-0.5",
    "abs(x)**1.3 + 2**y + abs(x)**z",
    "sin(3*x)*cos(2*y) + tan(z/2)",
    "exp(-x*x)*log(1 + y*y) + sqrt(abs(z))",
    "min(x, y) + max(y, z) + clip(x*y, -0.5, t)",
    "floor(3*x) + x % 0.7 + y % z",
    "where(x < y, x, y*z) + where(t > 0.2, 1, 2)",
    "(x < y) + 2*(y >= z) - (x != y)*(z == z)",
    "where(x*y, 3, 4) + min(x, y, z, 0.25)",
    "where((x > 0)*(y > 0), sin(x), -cos(pi*y))",
    "(x + 2*y - z)**7 * 1e-2",
]


@pytest.fixture(scope="module", params=["single", "double"])
def precision(request):
    return request.param


def on_points(precision, source, values):
    expression = Expression(source)

    def function(_, *packs):
        return (evaluate(expression, dict(zip(NAMES, packs, strict=True))),)

    return on_packs(precision, function, *values)[0]


@pytest.mark.parametrize("source", SOURCES)
def test_a_pack_has_the_values_that_numpy_has(precision, source):
    values = rounded(VALUES, precision)
    right = Expression(source).evaluate(dict(zip(NAMES, values, strict=True)))
    terms = np.maximum(np.abs(right), 1.0)
    # Near a jump of floor, % and comparisons the last bit decides; both sides of it are right.
    wrong = np.abs(on_points(precision, source, values) - right) > {"single": 1e-4, "double": 1e-11}[precision] * terms
    assert wrong.mean() < 0.005


def test_the_comparison_notices_a_wrong_coefficient():
    found = on_points("double", "2.001*x + 3*y - z/4", VALUES)
    right = Expression("2*x + 3*y - z/4").evaluate(dict(zip(NAMES, VALUES, strict=True)))
    assert (np.abs(found - right) > 1e-11).mean() > 0.9


def test_every_function_is_there():
    assert set(PACK_FUNCTIONS) == set(FUNCTION_NAMES) | {"pow"} == set(NUMPY_FUNCTIONS)


@pytest.mark.parametrize("source", ["sin(2)*2 + log(3)", "0", "2**0.3", "min(1, 2)"])
def test_a_constant_stays_a_python_number(source):
    value = evaluate(Expression(source), {})
    assert isinstance(value, float)
    assert value == pytest.approx(Expression(source).evaluate({}))


@pytest.mark.parametrize("name", sorted(PACK_FUNCTIONS))
def test_functions_of_plain_numbers_are_plain_numbers(name):
    arguments = {"clip": (0.4, 0.5, 0.6), "where": (True, 0.4, 0.6)}.get(name, (0.4, 0.5))
    count = 1 if name in {"sin", "cos", "tan", "exp", "log", "sqrt", "abs", "floor"} else len(arguments)
    value = PACK_FUNCTIONS[name](*arguments[:count])
    assert type(value) is float
    assert value == pytest.approx(float(NUMPY_FUNCTIONS[name](*arguments[:count])))


def test_a_derivative_that_repeats_its_parts_stays_right():
    source = "(1 + x*x*exp(-y*y)*sin(3*z))**3 / sqrt(x*x + y*y + z*z + 0.01)"
    step = 1e-5
    values = dict(zip(NAMES, VALUES, strict=True))
    for name in "xyz":
        ahead = Expression(source).evaluate({**values, name: values[name] + step})
        behind = Expression(source).evaluate({**values, name: values[name] - step})
        found = on_points("double", Expression(source).derivative(name).source, VALUES)
        np.testing.assert_allclose(found, (ahead - behind) / (2 * step), rtol=1e-5, atol=1e-6)

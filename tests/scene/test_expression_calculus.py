import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from particlecli.scene.expression import Expression
from tests.scene.expressions import NAMES, parsed, trees, values


@given(trees(smooth=True), values, st.sampled_from(NAMES))
@settings(max_examples=400, deadline=None)
def test_derivative_is_the_slope(source: str, values: dict[str, float], name: str) -> None:
    expression = parsed(source)
    step = 1e-4

    def at(offset: float) -> float:
        return float(expression.evaluate({**values, name: values[name] + offset}))

    with np.errstate(all="ignore"):
        slope = float(expression.derivative(name).evaluate(values))
        coarse = (at(step) - at(-step)) / (2 * step)
        fine = (at(step / 2) - at(-step / 2)) / step
        scale = 1 + abs(slope) + abs(at(0))
    assume(all(map(math.isfinite, (slope, coarse, fine, scale))))
    # Where halving the step still changes the difference, the formula is too wild there to compare with.
    assume(abs(coarse - fine) < 1e-5 * scale)
    assert fine == pytest.approx(slope, rel=1e-3, abs=1e-4 * scale)


@given(trees(), st.sampled_from(NAMES), values)
@settings(max_examples=200, deadline=None)
def test_source_of_a_derivative_reads_back(source: str, name: str, values: dict[str, float]) -> None:
    derivative = parsed(source).derivative(name)
    assume(len(derivative.source) < 2000)
    with np.errstate(all="ignore"):
        first = float(derivative.evaluate(values))
        assume(math.isfinite(first))
        second = float(parsed(derivative.source).evaluate(values))
    assert second == pytest.approx(first, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("source", "name", "derivative"),
    [
        ("3", "x", "0"),
        ("y", "x", "0"),
        ("x", "x", "1"),
        ("5*x + y", "x", "5"),
        ("x**2", "x", "2 * x"),
        ("0.5*3*x**2", "x", "3 * x"),
        ("sin(2*x)", "x", "2 * cos(2 * x)"),
        ("exp(-x)", "x", "-exp(-x)"),
        ("1/x", "x", "(-1) / x ** 2"),
        ("(x**2 + y**2)**-0.5", "x", "-((x ** 2 + y ** 2) ** (-1.5) * x)"),
        ("where(x < 0, -x, x)", "x", "where(x < 0, -1, 1)"),
        ("abs(x)", "x", "where(x < 0, -1, 1)"),
        ("floor(x)", "x", "0"),
        ("x > 0", "x", "0"),
    ],
)
def test_derivative_is_simplified(source: str, name: str, derivative: str) -> None:
    assert Expression(source).derivative(name).source == derivative


@pytest.mark.parametrize(
    "source",
    [
        *(f"{name}(x*y)" for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "abs")),
        *("x*y - y/x + x", "x**3", "x**-0.5", "(x*y)**0.3", "y**x", "x**y", "2**x", "(7*x) % 2", "x % (y*x)"),
        *("min(x, y)*x", "max(x*x, y)", "min(y, 2*x, x*x)", "where(x < y, x*x, 1/x)", "x*(x < y) + floor(x)"),
        *(
            "clip(x*x, y, 9)",
            "clip(x*x, 0.1, 2*x)",
            "clip(x*x, 3*x, 9*x)",
            "clip(x, 0, y*x)",
            "-(-x)",
            "-(x*-y)",
        ),
    ],
)
def test_derivative_of_everything(source: str) -> None:
    expression, step = Expression(source), 1e-6
    for x in (0.3, 0.71, 1.37):
        for y in (0.9, 2.3):

            def at(offset: float, x: float = x, y: float = y) -> float:
                return float(expression.evaluate({"x": x + offset, "y": y}))

            slope = float(expression.derivative("x").evaluate({"x": x, "y": y}))
            assert (at(step) - at(-step)) / (2 * step) == pytest.approx(slope, rel=1e-6, abs=1e-7)

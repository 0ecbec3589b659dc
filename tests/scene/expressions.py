"""Hypothesis strategies for expressions, and Python's own opinion of their values."""

import math

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from particlecli.scene.expression import Expression
from particlecli.scene.expression_tree import FLOAT_FUNCTIONS

NAMES = ("x", "y", "t")
PYTHON = {**FLOAT_FUNCTIONS, "pi": math.pi}


def numbers() -> st.SearchStrategy[str]:
    return st.one_of(
        st.integers(0, 20).map(str),
        st.floats(0.01, 50).map(lambda value: repr(round(value, 3))),
        st.just("pi"),
    )


def trees(smooth: bool = False) -> st.SearchStrategy[str]:
    """Formulas as fully bracketed text."""

    def grown(parts: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        operators = ["+", "-", "*", "/"] if smooth else ["+", "-", "*", "/", "%", "<", "<=", ">", ">=", "==", "!="]
        single = ["sin", "cos", "exp", "log", "sqrt"] if smooth else ["sin", "cos", "tan", "exp", "abs", "floor"]
        powers = ["2", "3", "-1"]
        fractions = ["0.5", "1.5", "-2.5", "0.3", "x"]  # of what is positive: Python makes complex numbers
        options = [
            st.tuples(parts, st.sampled_from(operators), parts).map(lambda three: "({} {} {})".format(*three)),
            st.tuples(st.sampled_from(single), parts).map(lambda two: "{}({})".format(*two)),
            parts.map(lambda part: f"(-{part})"),
            st.tuples(parts, st.sampled_from(powers)).map(lambda two: "({} ** {})".format(*two)),
            st.tuples(parts, st.sampled_from(fractions)).map(lambda two: "(({}**2 + 1) ** {})".format(*two)),
        ]
        if not smooth:
            options += [
                st.tuples(st.sampled_from(["min", "max"]), parts, parts).map(lambda all_: "{}({}, {})".format(*all_)),
                st.tuples(parts, parts, parts).map(lambda all_: "where({}, {}, {})".format(*all_)),
                st.tuples(parts, parts, parts).map(lambda all_: "clip({}, {}, {})".format(*all_)),
            ]
        return st.one_of(options)

    return st.recursive(st.one_of(numbers(), st.sampled_from(NAMES)), grown, max_leaves=8)


def by_python(source: str, values: dict[str, float]) -> float:
    """The value by Python's own eval; NaN where it has none."""
    try:
        value = eval(source, {"__builtins__": {}}, {**PYTHON, **{name: float(value) for name, value in values.items()}})
    except (ArithmeticError, ValueError):
        return math.nan
    return math.nan if isinstance(value, complex) else float(value)


def parsed(source: str) -> Expression:
    try:
        return Expression(source)
    except ValueError:
        # A constant part that has no finite value is refused, whatever surrounds it.
        assume(False)
        raise


# NumPy's floats: plain ones raise where a division has no value.
values = st.fixed_dictionaries(
    {name: st.floats(-3, 3).map(lambda value: np.float64(round(value, 2))) for name in NAMES}
)

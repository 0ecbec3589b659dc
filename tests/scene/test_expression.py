import math
import pickle
from typing import Annotated

import numpy as np
import pytest
from hypothesis import assume, given, settings
from pydantic import BaseModel, TypeAdapter, ValidationError

from particlecli.scene.expression import FUNCTION_NAMES, NUMPY_FUNCTIONS, Expression, Uses
from particlecli.scene.expression_tree import FLOAT_FUNCTIONS
from tests.scene.expressions import by_python, parsed, trees, values


@given(trees(), values)
@settings(max_examples=400, deadline=None)
def test_value_is_pythons(source: str, values: dict[str, float]) -> None:
    expression, expected = parsed(source), by_python(source, values)
    assume(math.isfinite(expected) and abs(expected) < 1e6)
    with np.errstate(all="ignore"):
        found = float(expression.evaluate(values))
    scale = 1 + max(abs(by_python(part, values)) for part in ("x", "y", "t")) + abs(expected)
    if "%" not in source and "floor" not in source and not any(mark in source for mark in "<>="):
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-9 * scale)
    else:
        # At a jump a rounding error may take the other side.
        assert math.isfinite(found)


@given(trees(), values)
@settings(max_examples=200, deadline=None)
def test_arrays_agree_with_floats(source: str, values: dict[str, float]) -> None:
    expression = parsed(source)
    with np.errstate(all="ignore"):
        one = np.asarray(expression.evaluate(values), float)
        many = np.broadcast_to(
            expression.evaluate({name: np.full(5, value) for name, value in values.items()}), 5
        ).astype(float)
    assume(np.isfinite(one))
    np.testing.assert_allclose(many, one, rtol=1e-9, atol=1e-9)


def test_whole_and_half_powers_need_no_pow() -> None:
    functions = {"sqrt": math.sqrt}
    for exponent in (-3, -2.5, -0.5, 0, 0.5, 1, 1.5, 2, 7, 64):
        value = Expression(f"x**{exponent}").evaluate({"x": 1.7}, functions)
        assert value == pytest.approx(1.7**exponent, rel=1e-14)
    assert Expression("x**0.3").evaluate({"x": 1.7}, {"pow": math.pow}) == 1.7**0.3


def test_comparisons_are_numbers() -> None:
    x = np.array([-1.0, 0.5, 2.0])
    np.testing.assert_array_equal(Expression("(x > 0) + (x > 1)").evaluate({"x": x}), [0, 1, 2])
    np.testing.assert_array_equal(Expression("-(x > 0)").evaluate({"x": x}), [0, -1, -1])
    np.testing.assert_array_equal(Expression("0 < x < 1").evaluate({"x": x}), [0, 1, 0])
    np.testing.assert_array_equal(Expression("where(x, 1, 2)").evaluate({"x": x * [1, 0, 1]}), [1, 2, 1])


def test_function_tables_are_complete() -> None:
    wanted = {*FUNCTION_NAMES, "pow"}
    assert set(NUMPY_FUNCTIONS) == set(FLOAT_FUNCTIONS) == wanted


@pytest.mark.parametrize("source", [math.nan, math.inf, -math.inf, True, None, [1], "nan", "inf", "1e999"])
def test_not_a_finite_number(source: object) -> None:
    if source in ("nan", "inf"):
        assert Expression(source).names == {source}  # type: ignore[arg-type]
        return
    with pytest.raises(ValueError, match=r"must be|too large"):
        Expression(source)  # type: ignore[arg-type]


def test_equal_by_source_and_immutable() -> None:
    expression = Expression("2*x")
    assert expression == Expression("2*x") != Expression("x*2")
    assert len({expression, Expression("2*x")}) == 1
    assert pickle.loads(pickle.dumps(expression)).evaluate({"x": 3.0}) == 6
    with pytest.raises(AttributeError):
        expression.source = "x"  # type: ignore[misc]


@pytest.mark.parametrize(
    ("written", "plain"), [(75, 75), (0.5, 0.5), ("75", 75), (" 1e3 ", 1000.0), ("2*t", "2*t"), (-3, -3)]
)
def test_numbers_stay_numbers(written: str | float, plain: str | float) -> None:
    expression = Expression(written)
    assert expression.plain == plain
    assert type(expression.plain) is type(plain)
    assert Expression(expression.plain) == expression


def test_constant() -> None:
    assert Expression("2*pi").constant == 2 * math.pi
    assert Expression("t").constant is None


def test_is_a_pydantic_type() -> None:
    adapter = TypeAdapter(Expression)
    assert adapter.validate_python("t + 1").names == {"t"}
    assert adapter.dump_python(adapter.validate_python(3)) == 3
    assert adapter.dump_python(adapter.validate_python("t + 1")) == "t + 1"
    assert adapter.json_schema() == {"type": ["number", "string"]}
    with pytest.raises(ValidationError, match="must be a number or an expression"):
        adapter.validate_python(True)


def test_uses_refuses_other_names() -> None:
    check = Uses("t")
    assert check.check(Expression("sin(t)")) == Expression("sin(t)")
    with pytest.raises(ValueError, match=r"unknown name `xt`; known here: t and pi\n    t \+ xt\n        \^"):
        check.check(Expression("t + xt"))
    with pytest.raises(ValueError, match="unknown name `Pi`; did you mean `pi`"):
        check.check(Expression("Pi"))


def test_uses_is_an_annotation() -> None:
    class Model(BaseModel):
        rate: Annotated[Expression, Uses("t")]

    assert Model(rate="2*t").rate.source == "2*t"  # type: ignore[arg-type]
    with pytest.raises(ValidationError, match="unknown name `x`"):
        Model(rate="2*x")  # type: ignore[arg-type]

import re

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from particlecli.scene.expression import Expression
from particlecli.scene.expression_parser import parse
from particlecli.scene.expression_tree import text
from tests.scene.expressions import trees


@given(trees())
@example("(x < y) < t")
@example("x < (y < t)")
@example("(x ** y) ** t")
@example("x ** y ** t")
@example("(-x) ** 2")
@example("-x ** 2")
@example("x - (y - t)")
@example("x / (y * t)")
@settings(max_examples=200, deadline=None)
def test_text_of_a_tree_parses_to_it(source: str) -> None:
    try:
        tree = parse(source)
    except ValueError:
        assume(False)
        raise
    assert parse(text(tree)) == tree


@pytest.mark.parametrize(
    ("source", "message", "caret"),
    [
        ("x.real", "a dot between names has no meaning here", 0),
        ("1 + x[0]", "square brackets have no meaning here", 4),
        ("open('f')", "unknown function `open`", 0),
        ("2*sine(t)", "did you mean `sin`?", 2),
        ("sin()", "`sin` takes one argument, not 0", 0),
        ("1 + sin(1, 2)", "`sin` takes one argument, not 2", 4),
        ("clip(t, 1)", "`clip` takes three arguments, not 2", 0),
        ("min(t)", "`min` takes two to 16 arguments, not 1", 0),
        ("sin(x=1)", "arguments have no names", 6),
        ("sin(*x)", "a star before an argument", 4),
        ("sin + 1", "`sin` is a function", 0),
        ("'a' + 1", "only numbers, names and functions", 0),
        ("True", "only numbers", 0),
        ("2j", "only numbers", 0),
        ("lambda: 1", "only arithmetic", 0),
        ("x if t else y", "where(condition, value, otherwise)", 0),
        ("x and y", "max(a, b)", 0),
        ("not x", "1 - a", 0),
        ("x^2", "write ** for a power", 0),
        ("x // 2", "floor(a / b)", 0),
        ("[x]", "only arithmetic", 0),
        ("(x := 1)", "only arithmetic", 1),
        ("(lambda: 1)()", "only arithmetic", 0),
        ("t + 1/0", "division by zero", 6),
        ("t / (2 - 2)", "division by zero", 5),
        ("t % 0", "division by zero", 4),
        ("t * exp(1000)", "not a finite real number", 4),
        ("sqrt(-1) * t", "not a finite real number", 0),
        ("log(0)", "not a finite real number", 0),
        ("(-8)**0.5", "not a finite real number", 0),
        ("9**9**9**9", "not a finite real number", 3),
        ("1e999", "the number is too large", 0),
        ("5*(t", "not an arithmetic expression", 2),
        ("2 x", "not an arithmetic expression", None),
        ("x +", "not an arithmetic expression", None),
        ("x # y", "# has no meaning", 2),
        ("é + x.y", "a dot between names", 4),
        ("import os", "not an arithmetic expression", None),
        ("x; y", "not an arithmetic expression", None),
    ],
)
def test_refused_with_the_place(source: str, message: str, caret: int | None) -> None:
    with pytest.raises(ValueError, match=re.escape(message)) as caught:
        Expression(source)
    _, shown, pointer = str(caught.value).split("\n")
    assert shown == f"    {source}"
    if caret is not None:
        assert pointer == " " * (4 + caret) + "^"


@pytest.mark.parametrize(
    "source",
    [
        "",
        "   ",
        "\0",
        "x" * 2001,
        "(" * 1000,
        "-" * 1999 + "x",
        "+".join("x" * 300),
        "1" * 1500,
        "sin(" * 400 + "x",
    ],
)
def test_too_long_deep_or_empty(source: str) -> None:
    with pytest.raises(
        ValueError, match=r"must not|characters at most|nested|not an arithmetic|cannot be read|too large"
    ):
        Expression(source)


def test_long_text_is_shown_around_the_place() -> None:
    source = "+".join(["x"] * 60) + "+y.z+" + "+".join(["x"] * 60)
    with pytest.raises(ValueError, match="a dot") as caught:
        Expression(source)
    _, shown, pointer = str(caught.value).split("\n")
    assert len(shown) < 80
    assert shown[pointer.index("^") :].startswith("y.z")


@given(st.text(max_size=60))
@example("1_0")
@example("0x10")
@example("\ud800")
@example("x\n+1")
@settings(max_examples=500, deadline=None)
def test_any_text_is_an_expression_or_a_value_error(source: str) -> None:
    try:
        expression = Expression(source)
    except ValueError:
        return
    assert Expression(expression.source) == expression

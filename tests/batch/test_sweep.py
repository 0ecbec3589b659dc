from __future__ import annotations

import pytest

from particlecli.batch.sweep import combinations, parse_sweep
from particlecli.errors import UsageError


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a=1", ["1"]),
        ("a = 0.01, 0.005", ["0.01", "0.005"]),
        ("a=[0, 1, 0],[1, 0, 0]", ["[0, 1, 0]", "[1, 0, 0]"]),
        ("a={type: euler, dt: 1}", ["{type: euler, dt: 1}"]),
        ("a='x,y',\"z,\"", ["'x,y'", '"z,"']),
        ("a=", [""]),
        ("a=linspace(0,1,5)", ["0", "0.25", "0.5", "0.75", "1"]),
        ("a= linspace(0.1, 0.3, 3)", ["0.1", "0.2", "0.3"]),
        ("a=linspace(1, -1, 2)", ["1", "-1"]),
        ("a=geomspace(1e-3, 1, 4)", ["0.001", "0.01", "0.1", "1"]),
        ("a=geomspace(-1, -4, 3)", ["-1", "-2", "-4"]),
    ],
)
def test_values(text: str, values: list[str]) -> None:
    sweep = parse_sweep(text)
    assert (sweep.key, list(sweep.values)) == ("a", values)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a", "key=value"),
        ("=1", "key=value"),
        ("a=1,,2", "missing between"),
        ("a=1,2,1", "the value 1 is there twice"),
        ("a=linspace(0,1)", "first, last, count"),
        ("a=linspace(0,1,1)", "2 to 10,000"),
        ("a=linspace(0,1,2.5)", "2 to 10,000"),
        ("a=linspace(0,1,1e9)", "2 to 10,000"),
        ("a=linspace(0,inf,3)", "2 to 10,000"),
        ("a=linspace(3,3,3)", "the value 3 is there twice"),
        ("a=geomspace(0,1,3)", "one sign"),
        ("a=geomspace(-1,1,3)", "one sign"),
    ],
)
def test_mistakes(text: str, says: str) -> None:
    with pytest.raises(UsageError, match=says):
        parse_sweep(text)


def test_every_combination_the_last_fastest() -> None:
    made = combinations([parse_sweep("a=1,2"), parse_sweep("b=3"), parse_sweep("c=4,5")])
    assert [[value for _, value in each] for each in made] == [
        ["1", "3", "4"], ["1", "3", "5"], ["2", "3", "4"], ["2", "3", "5"]
    ]  # fmt: skip
    assert combinations([]) == [()]


def test_a_key_twice() -> None:
    with pytest.raises(UsageError, match=r"--set a is given twice"):
        combinations([parse_sweep("a=1"), parse_sweep("a=2")])

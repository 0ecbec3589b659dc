import math

import pytest

from particlecli.scene.scalars import resolve


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e3", 1000.0),
        ("1E-3", 0.001),
        ("1.0e-6", 1e-6),
        ("010", 10),
        ("-007", -7),
        (".5", 0.5),
        ("5.", 5.0),
        ("+1", 1),
        ("-0", 0),
        ("1_000", 1000),
        ("1_000.5", 1000.5),
        ("0x1F", 31),
        ("0o17", 15),
        (".inf", math.inf),
        ("-.INF", -math.inf),
        ("true", True),
        ("FALSE", False),
        ("null", None),
        ("~", None),
        ("", None),
        ("9" * 400, math.inf),
    ],
)
def test_values(text: str, value: object) -> None:
    found = resolve(text)
    assert found == value
    assert type(found) is type(value)


def test_nan() -> None:
    assert math.isnan(resolve(".nan"))


@pytest.mark.parametrize(
    "text",
    [
        "yes",
        "No",
        "on",
        "off",
        "y",
        "n",
        "1:30",
        "2001-01-01",
        "1__0",
        "_1",
        "1_",
        "e3",
        "1e",
        ".",
        "inf",
        "nan",
        "0b1",
        "1 2",
        "tRue",
    ],
)
def test_words(text: str) -> None:
    assert resolve(text) == text

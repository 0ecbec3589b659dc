"""Sweeps: `key=0.01,0.005` and `key=linspace(0, 1, 5)` as lists of values."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from particlecli.errors import UsageError

MOST_VALUES = 10_000

_CALL = re.compile(r"\s*(linspace|geomspace)\s*\((.*)\)\s*")
_OPENING, _CLOSING = "([{", ")]}"


@dataclass(frozen=True)
class Sweep:
    """The values that a key of the scenes takes.

    Attributes:
        key: dotted.
        values: as they would be written in a scene.
    """

    key: str
    values: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.values)


def parse_sweep(assignment: str) -> Sweep:
    """Reads `key=value`, `key=value,value…`, `key=linspace(first, last, count)` or geomspace likewise.

    Commas within brackets and quotes belong to a value.

    Raises:
        UsageError: it is none of these, or gives one value twice.
    """
    key, equals, text = assignment.partition("=")
    if not equals or not key.strip():
        raise UsageError(f"--set {assignment}: write it as key=value, or key=value,value,… to run each")
    call = _CALL.fullmatch(text)
    values = _spaced(assignment, call[1], call[2]) if call else _split(text)
    if "" in values and len(values) > 1:
        raise UsageError(f"--set {assignment}: a value is missing between two commas")
    repeated = next((value for place, value in enumerate(values) if value in values[:place]), None)
    if repeated is not None:
        raise UsageError(
            f"--set {assignment}: the value {repeated} is there twice, and both would write the same output"
        )
    return Sweep(key.strip(), tuple(values))


def combinations(sweeps: Sequence[Sweep]) -> list[tuple[tuple[str, str], ...]]:
    """Every combination of values, each as pairs of key and value; the last sweep varies fastest.

    Raises:
        UsageError: a key is given twice.
    """
    keys = [sweep.key for sweep in sweeps]
    twice = next((key for place, key in enumerate(keys) if key in keys[:place]), None)
    if twice is not None:
        raise UsageError(f"--set {twice} is given twice; give all its values in one: --set {twice}=1,2")
    pairs = [[(sweep.key, value) for value in sweep.values] for sweep in sweeps]
    return list(itertools.product(*pairs))


def _split(text: str) -> list[str]:
    values, depth, quote, begin = [], 0, "", 0
    for place, letter in enumerate(text):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter in _OPENING:
            depth += 1
        elif letter in _CLOSING:
            depth -= 1
        elif letter == "," and depth == 0:
            values.append(text[begin:place].strip())
            begin = place + 1
    return [*values, text[begin:].strip()]


def _spaced(assignment: str, name: str, arguments: str) -> list[str]:
    try:
        first, last, count = map(float, arguments.split(","))
        if not (count.is_integer() and 2 <= count <= MOST_VALUES and math.isfinite(first) and math.isfinite(last)):
            raise ValueError
        if name == "geomspace" and first * last <= 0:
            raise ValueError
    except (ValueError, OverflowError):
        why = ", both ends of one sign" if name == "geomspace" else ""
        raise UsageError(
            f"--set {assignment}: write {name}(first, last, count) with 2 to {MOST_VALUES:,} values{why}"
        ) from None
    spaces: dict[str, Callable[[float], float]] = {
        "linspace": lambda share: first + share * (last - first),
        "geomspace": lambda share: math.copysign(abs(first) * (last / first) ** share, first),
    }
    values = [first, *(spaces[name](step / (count - 1)) for step in range(1, int(count) - 1)), last]
    return [f"{value:.12g}" for value in values]

"""Small plots of numbers over time, one line of text high."""

from __future__ import annotations

from collections.abc import Sequence

BARS = "▁▂▃▄▅▆▇█"


def sparkline(values: Sequence[float], width: int) -> str:
    """At most `width` characters, each as high as the mean of its share of the values.

    The lowest bar is the least value and the highest the largest; values that are not finite leave a gap.
    """
    cells = [_mean(values[start:stop]) for start, stop in _shares(len(values), width)]
    known = [cell for cell in cells if cell is not None]
    low, high = min(known, default=0.0), max(known, default=0.0)
    return "".join(" " if cell is None else BARS[_height(cell, low, high)] for cell in cells)


def _shares(count: int, width: int) -> list[tuple[int, int]]:
    cells = min(count, width)
    return [(cell * count // cells, (cell + 1) * count // cells) for cell in range(cells)]


def _mean(values: Sequence[float]) -> float | None:
    mean = sum(values) / len(values)
    return mean if abs(mean) < float("inf") else None


def _height(value: float, low: float, high: float) -> int:
    if high <= low:
        return 0
    # Halved, so that a range between the largest numbers does not overflow.
    share = (value / 2 - low / 2) / (high / 2 - low / 2)
    return min(len(BARS) - 1, int(share * len(BARS)))

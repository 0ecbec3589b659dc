"""Where the levels of an image pyramid lie in its buffer, and the bands that workers splat."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MARGIN = 8
"""Nodes around the picture on each level; even, so that halving keeps nodes on nodes."""

CLEARANCE = 2
"""A splat's place keeps so many nodes from the buffer's edge; light centred further out does not reach in."""

BAND = 8
"""Rows a worker splats at a time; twice a splat's 4 rows, so that every other band is independent."""

COARSEST = 5
"""The levels end with the first whose shorter side has fewer nodes than this."""

OFFSET, PITCH, WIDTH, HEIGHT, BANDS, SHIFT, BIN = range(7)
"""Columns of a layout's table."""


@dataclass(frozen=True)
class Level:
    """One level: where it starts in the buffer, nodes from row to row, size without margins, bands."""

    offset: int
    pitch: int
    width: int
    height: int
    bands: int

    @property
    def rows(self) -> int:
        """Rows with margins."""
        return self.height + 2 * MARGIN + CLEARANCE

    @property
    def origin(self) -> int:
        """Node of the picture's first pixel."""
        return self.offset + MARGIN * self.pitch + MARGIN

    @property
    def end(self) -> int:
        """Where the next level starts."""
        return self.offset + self.rows * self.pitch


def levels_of(width: int, height: int, offset: int = 0) -> tuple[Level, ...]:
    """The levels of a picture of `width` × `height` pixels, from node `offset` on, finest first; two at least."""
    levels: list[Level] = []
    while len(levels) < 2 or min(levels[-1].width, levels[-1].height) >= COARSEST:
        rows = height + 2 * MARGIN + CLEARANCE
        levels.append(Level(offset, width + 2 * MARGIN + CLEARANCE, width, height, math.ceil(rows / BAND)))
        offset = levels[-1].end
        width, height = (width + 1) // 2, (height + 1) // 2
    return tuple(levels)


def table_of(levels: tuple[Level, ...], first: int) -> NDArray[np.int32]:
    """The levels for kernels, shape (levels, 7); the coarser levels' halos are kept from place `first` on.

    Sprites of class 0 have the first bins, one for each band of level 0; then come those of class 1, which has the
    bands of level 0 too, and of each further class c, with the bands of level c − 1.
    """
    shift = levels[1].offset - first
    bins = levels[0].bands + np.cumsum([0, *(level.bands for level in levels)])
    rows = [
        (level.offset, level.pitch, level.width, level.height, level.bands, shift, bin_)
        for level, bin_ in zip(levels, bins, strict=False)
    ]
    return np.array(rows, np.int32)


def bins_of(levels: tuple[Level, ...]) -> int:
    """How many bins sprites are sorted into."""
    return levels[0].bands + sum(level.bands for level in levels)


def deviation(level: int) -> float:
    """Standard deviation of a splat of one level on the picture, pixels: √((5·4^l − 2)/6)."""
    return math.sqrt((5 * 4.0**level - 2) / 6)

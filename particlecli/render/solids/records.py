"""What the bodies of a picture are sorted and drawn from: a row of numbers for each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

X, Y, DEPTH, LOOK, EXTENT = range(5)
"""The first numbers of every row: middle, pixels; depth, m; place of its look in the table of looks; and how far from
its middle it reaches, pixels, 0 where nothing is to be drawn."""

RADIUS, COSINE, SINE, PICTURE, ALPHA, RED, GREEN, BLUE, BLUR = range(5, 14)
"""A billboard: radius, pixels; how it is turned; number of its picture on the sheet; how much it hides; tint; radius
of the lens's blur, pixels."""

END_X, END_Y, HALF, HIDES, FROM_RED, TO_RED = 5, 6, 7, 8, 9, 12
"""A piece of a ribbon: from its middle to its end, pixels; half of its width, pixels; how much it hides; light at its
start and its end, three numbers each."""

FIRST_X, FIRST_Y, SECOND_X, SECOND_Y, CORNERS, EDGES, OPACITY = 5, 6, 7, 8, 9, 18, 19
"""A triangle: from its middle to two of its corners, pixels; light at the three corners, three numbers each; which
edges are outlines, 1 + 2 + 4; how much it hides."""

NUMBERS, MOST_NUMBERS = 14, 20
"""Numbers in a row where there are billboards alone, and else."""

HIDDEN = 65535
"""Key of what is not drawn; others are sorted by depth, nearest first."""


class Rows:
    """Rows and their keys, reused from frame to frame.

    Attributes:
        rows: shape (room, numbers).
        keys: shape (room,), by which rows are sorted.
        count: how many are in use.
    """

    def __init__(self, numbers: int) -> None:
        self.rows: NDArray[np.float32] = np.zeros((1, numbers), np.float32)
        self.keys: NDArray[np.uint16] = np.zeros(1, np.uint16)
        self.count = 0

    def clear(self, room: int) -> None:
        """Take all rows away, and make room for so many."""
        self.count = 0
        if len(self.rows) < room:
            self.rows = np.zeros((room, self.rows.shape[1]), np.float32)
            self.keys = np.zeros(room, np.uint16)

    def take(self, count: int) -> int:
        """The first of `count` more rows."""
        first = self.count
        self.count += count
        return first

"""What the bodies of a picture are sorted and drawn from: a head for each, and a row for all but specks.

Heads are copied to the tiles that bodies touch. So they are small: what moves through memory takes most of the time of
a picture of a million bodies.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

X, Y, DEPTH, EXTENT = range(4)
"""The first numbers of a head: middle, pixels; depth, m; and how far from its middle it reaches, pixels, 0 where
nothing is to be drawn."""

LIGHT, HIDES = 4, 7
"""The others of a speck, which is a disc of one colour: its light, three numbers, and how much it hides, 0 to 1."""

LOOK, ROW, LARGE = 4, 5, -1.0
"""The others of what is larger: place of its look in the table of looks, the bits of its row's number, and HIDES is
LARGE."""

HEAD = 8
"""Numbers in a head."""

RADIUS, COSINE, SINE, PICTURE, ALPHA, RED, GREEN, BLUE, BLUR = range(9)
"""The row of a billboard: radius, pixels; how it is turned; number of its picture on the sheet; how much it hides;
tint; radius of the lens's blur, pixels."""

END_X, END_Y, HALF, COVER, FROM_RED, TO_RED = 0, 1, 2, 3, 4, 7
"""Of a piece of a ribbon: from its middle to its end, pixels; half of its width, pixels; how much it hides; light at
its start and its end, three numbers each."""

FIRST_X, FIRST_Y, SECOND_X, SECOND_Y, CORNERS, EDGES, OPACITY = 0, 1, 2, 3, 4, 13, 14
"""Of a triangle: from its middle to two of its corners, pixels; light at the three corners, three numbers each; which
edges are outlines, 1 + 2 + 4; how much it hides."""

NUMBERS, MOST_NUMBERS = 9, 15
"""Numbers in a row where there are billboards alone, and else."""

Floats = NDArray[np.float32]


class Records:
    """Heads and rows, reused from frame to frame.

    Attributes:
        heads: shape (room, HEAD).
        rows: shape (room, numbers).
        count: how many are in use.
    """

    def __init__(self, numbers: int) -> None:
        self.heads: Floats = np.zeros((1, HEAD), np.float32)
        self.rows: Floats = np.zeros((1, numbers), np.float32)
        self.count = 0

    def clear(self, room: int) -> None:
        """Take all away, and make room for so many."""
        self.count = 0
        if len(self.rows) < room:
            self.heads = np.zeros((room, HEAD), np.float32)
            self.rows = np.zeros((room, self.rows.shape[1]), np.float32)

    def take(self, count: int) -> int:
        """The first of `count` more."""
        first = self.count
        self.count += count
        return first

    def add(self, count: int, look: int) -> tuple[Floats, Floats]:
        """Heads and rows of `count` more of a look that are no specks, the heads complete but for where they are."""
        first = self.take(count)
        heads = self.heads[first : first + count]
        heads[:, LOOK], heads[:, HIDES] = look, LARGE
        heads[:, ROW] = np.arange(first, first + count, dtype=np.int32).view(np.float32)
        return heads, self.rows[first : first + count]

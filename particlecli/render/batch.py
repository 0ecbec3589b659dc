"""Sprites of several groups that are sorted and drawn at once."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from particlecli.render.discs import draw_discs
from particlecli.render.pyramid import Pyramid
from particlecli.render.soft import draw_soft
from particlecli.render.sprites import PACK, Span, store_for


class Batch:
    """Sprites that wait until all of a picture's are there, or there is no room for more.

    Attributes:
        store: where they are.
    """

    def __init__(self, pyramids: Mapping[int, Pyramid], colors: NDArray[np.float32], total: int) -> None:
        """An empty batch.

        Args:
            pyramids: where each set of sprites is drawn.
            colors: shape (places, 4), tables of all tints.
            total: how many sprites are to come; more than there is room for are drawn in several goes.
        """
        self.store = store_for(total)
        self._pyramids, self._colors = pyramids, colors
        self._spans: dict[int, list[Span]] = {which: [] for which in pyramids}
        self._taken = 0

    def take(self, count: int) -> int:
        """The first of so many places in each set, MANY at most; what waits is drawn if it takes up the room."""
        if self._taken + count > self.store.size:
            self.draw()
        first = self._taken
        self._taken = first + count + -count % PACK
        return first

    def add(self, which: int, span: Span) -> None:
        """Let sprites of a set wait."""
        self._spans[which].append(span)

    def draw(self) -> None:
        """Draw what waits."""
        for which, spans in self._spans.items():
            for draw, crisp in ((draw_soft, False), (draw_discs, True)):
                alike = [span for span in spans if span.crisp is crisp]
                if alike:
                    draw(self.store, which, alike, self._pyramids[which], self._colors)
            spans.clear()
        self._taken = 0

"""The raster for soft light: sprites of any size and their smears, into a pyramid."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from particlecli.render.pyramid import Pyramid
from particlecli.render.records import Chunks, draw_in_parts
from particlecli.render.soft_kernels import sort_soft, splat
from particlecli.render.sprites import Span, Store


def draw_soft(store: Store, which: int, spans: Sequence[Span], pyramid: Pyramid, colors: NDArray[np.float32]) -> None:
    """Add soft sprites to a pyramid's light.

    Args:
        store: where the sprites are, in pixels of the pyramid's level 0.
        which: their set.
        spans: which sprites of the set.
        pyramid: takes the light.
        colors: shape (places, 4), tables of all tints.
    """
    counter = np.zeros(2, np.int32)
    last = len(pyramid.levels) - 1

    def draw(chunks: Chunks) -> int:
        for placing in (False, True):
            sort_soft(
                chunks, which, store.sprites, store.records, store.counts, pyramid.table, last, counter, placing
            )  # fmt: skip
            needed = int(counter[1])
            if needed > store.room:
                return needed
        for parity in (0, 1):
            splat(
                chunks, store.records, store.counts, pyramid.table, last, pyramid.arena.light, colors, counter, parity
            )  # fmt: skip
        return needed

    draw_in_parts(spans, store, pyramid.bins, draw)

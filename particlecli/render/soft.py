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
    total = np.zeros(1, np.int32)
    last = len(pyramid.levels) - 1
    sorting = (store.records, store.counts, pyramid.table, last)

    def sort(chunks: Chunks, placing: bool) -> int:
        sort_soft(chunks, which, store.sprites, *sorting, total, placing)
        return int(total[0])

    def add(chunks: Chunks) -> None:
        for parity in (0, 1):
            tasks = sum((level.bands + 1 - parity) // 2 for level in pyramid.levels)
            splat(chunks, *sorting, pyramid.arena.light, colors, parity, tasks)

    draw_in_parts(spans, store, pyramid.bins, sort, add)

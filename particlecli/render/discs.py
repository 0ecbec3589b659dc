"""The raster for crisp discs, at the resolution of the picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from particlecli.render.disc_kernels import sort_discs, splat_discs
from particlecli.render.layout import BAND
from particlecli.render.pyramid import Pyramid
from particlecli.render.records import Chunks, draw_in_parts
from particlecli.render.sprites import Span, Store


def draw_discs(store: Store, which: int, spans: Sequence[Span], pyramid: Pyramid, colors: NDArray[np.float32]) -> None:
    """Add sprites, as discs, to the finest level of a pyramid. The cost grows with their area.

    Args:
        store: where the sprites are.
        which: their set.
        spans: which sprites of the set.
        pyramid: takes the light.
        colors: shape (places, 4), tables of all tints.
    """
    total = np.zeros(1, np.int32)
    finest = pyramid.levels[0]
    bands = finest.rows // BAND
    sorting = (store.sprites, store.records, store.counts, finest.pitch, bands)

    def sort(chunks: Chunks, placing: bool) -> int:
        sort_discs(chunks, which, *sorting, total, placing)
        return int(total[0])

    def add(chunks: Chunks) -> None:
        splat_discs(chunks, which, *sorting, pyramid.arena.light, finest.offset, colors)

    draw_in_parts(spans, store, bands, sort, add)

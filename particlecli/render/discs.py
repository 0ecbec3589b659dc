"""The raster for crisp discs, at the resolution of the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.render.disc_kernels import draw_discs
from particlecli.render.layout import BAND
from particlecli.render.pyramid import Pyramid
from particlecli.render.records import draw_in_parts
from particlecli.render.sprites import Sprites


class DiscRaster:
    """Draws discs. Its cost grows with their area."""

    def __init__(self) -> None:
        self._counter = np.zeros(2, np.int32)

    def draw(self, sprites: Sprites, count: int, pyramid: Pyramid, colors: NDArray[np.float32], *, halo: float) -> None:
        """Add the first `count` sprites, as discs, to the finest level of the pyramid.

        Args:
            sprites: where, how large and how bright.
            count: how many.
            pyramid: takes the light.
            colors: shape (places, 4), a tint's table.
            halo: share of the light that forms a halo around each disc.
        """
        finest = pyramid.levels[0]
        bands = finest.rows // BAND
        store = sprites.store

        def draw(first: int, end: int) -> int:
            draw_discs(
                first, end, sprites.which, store.sprites, store.records, store.counts, store.room, finest.pitch, bands,
                pyramid.arena.light, finest.offset, colors, halo, self._counter,
            )  # fmt: skip
            return int(self._counter[1])

        draw_in_parts(count, store, bands, draw)

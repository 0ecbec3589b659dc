"""The raster for soft light: sprites of any size and their smears, into a pyramid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.render.pyramid import Pyramid
from particlecli.render.records import draw_in_parts
from particlecli.render.soft_kernels import draw_soft
from particlecli.render.sprites import Sprites


class SoftRaster:
    """Draws soft sprites."""

    def __init__(self) -> None:
        self._counter = np.zeros(2, np.int32)

    def draw(
        self, sprites: Sprites, count: int, pyramid: Pyramid, colors: NDArray[np.float32], *,
        halo: float, smeared: bool = False,
    ) -> None:  # fmt: skip
        """Add the first `count` sprites to the pyramid's light.

        Args:
            sprites: where and how bright, in pixels of the pyramid's level 0.
            count: how many.
            pyramid: takes the light.
            colors: shape (places, 4), a tint's table.
            halo: share of the light that forms a halo around each sprite.
            smeared: whether to draw tails.
        """
        store = sprites.store
        last = len(pyramid.levels) - 1

        def draw(first: int, end: int) -> int:
            draw_soft(
                first, end, sprites.which, store.sprites, store.records, store.counts, store.room, pyramid.table, last,
                pyramid.arena.light, colors, halo, self._counter, smeared,
            )  # fmt: skip
            return int(self._counter[1])

        draw_in_parts(count, store, pyramid.bins, draw)

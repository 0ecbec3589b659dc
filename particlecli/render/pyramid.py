"""The image pyramid that light is gathered in: level 0 is the picture, each further level half as fine.

Node j of level l lies on pixel j·2^l, so that halving and doubling keep centroids exactly. A sprite is
splatted, 4 × 4 nodes, into the two levels whose nodes are about as far apart as it is wide, which costs the
same for every size; `collapse` brings the levels together by cubic B-spline subdivision.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from particlecli.render.arena import Arena, arena_for
from particlecli.render.layout import Level, bins_of, deviation, levels_of, table_of
from particlecli.render.spread import clear, gather, settle_small, widen

SMALL = 1 << 14
"""Levels of no more nodes are settled by one thread, in one go."""


def pyramids_of(sizes: Sequence[tuple[int, int]]) -> list[Pyramid]:
    """Pyramids of pictures of some widths and heights, side by side in one arena."""
    geometries: list[tuple[Level, ...]] = []
    halos = [0]
    for width, height in sizes:
        levels = levels_of(width, height, geometries[-1][-1].end if geometries else 0)
        geometries.append(levels)
        halos.append(halos[-1] + levels[-1].end - levels[1].offset)
    arena = arena_for(geometries[-1][-1].end, halos[-1], max(levels[0].pitch for levels in geometries))
    return [Pyramid(levels, arena, first) for levels, first in zip(geometries, halos, strict=False)]


def clear_together(first: Pyramid, last: Pyramid) -> None:
    """Take all light away from pyramids that lie side by side."""
    clear(first.arena.light, first.levels[0].offset, last.levels[-1].end)


class Pyramid:
    """Linear light on all levels of a picture.

    Attributes:
        levels: their geometry, finest first.
        arena: where the light is.
        table, bins: the geometry for kernels, and how many bins sprites are sorted into; see `layout`.
    """

    def __init__(self, levels: tuple[Level, ...], arena: Arena, first: int) -> None:
        """Light from the first level's offset on, halos from the place `first` on."""
        self.levels = levels
        self.arena = arena
        self.table = table_of(self.levels, first)
        self.bins = bins_of(self.levels)

    @property
    def largest(self) -> float:
        """Radius of the largest sprite that the coarsest level can carry, pixels."""
        return 2 * deviation(len(self.levels) - 1)

    def clear(self, first: int = 0) -> None:
        """Take all light away from the levels from the `first` on."""
        clear(self.arena.light, self.levels[first].offset, self.levels[-1].end)

    def collapse(self, share: float = 0.0, stays: NDArray[np.float32] | None = None, *, onto: int) -> None:
        """Spread halos and bloom over the coarser levels, then bring these together.

        Args:
            share: of the light that the lens scatters.
            stays: shape (levels,); the part of the scattered light that settles on each level, of what came.
            onto: the level that the light ends on. With 1, level 0 keeps its light, of which the halo's part
                is to be taken away, and whoever reads the picture adds level 1 to it.
        """
        steps = np.zeros(len(self.levels), np.float32) if stays is None else stays
        buffers = (self.arena.light, self.arena.halo, self.arena.bloom)
        rest = (self.table, steps, share)
        last = len(self.levels) - 1
        small = next(place for place in range(1, last + 1) if self._is_small(place) or place == last)
        for place in range(small):
            widen(place, *buffers, *rest, place == 0)
        settle_small(small, last, *buffers, *rest)
        for place in range(small - 1, onto - 1, -1):
            gather(place, last, *buffers, *rest, place == 0)

    def _is_small(self, place: int) -> bool:
        return self.levels[place].width * self.levels[place].height <= SMALL

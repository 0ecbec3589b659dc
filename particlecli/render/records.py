"""Sorting sprites in as many goes as it takes for their records to have room."""

from __future__ import annotations

from collections.abc import Callable

from particlecli.render.sprites import PACK, Store

Draw = Callable[[int, int], int]
"""Sorts and draws the sprites from the first to before the end; tells how many records that takes. Where the store
has no room for so many, it draws nothing."""


def draw_in_parts(count: int, store: Store, bins: int, draw: Draw) -> None:
    """Draw `count` sprites in their order, sorted into so many bins, at once if possible.

    A few sprites always have room: none takes more than a few thousand records.
    """
    most = store.most(bins)
    parts = [(first, min(first + most, count)) for first in range(0, count, most)]
    while parts:
        first, end = parts.pop(0)
        needed = draw(first, end)
        if needed > store.room:
            step = max(PACK, (end - first) * store.room // (2 * needed) // PACK * PACK)
            parts[:0] = [(start, min(start + step, end)) for start in range(first, end, step)]

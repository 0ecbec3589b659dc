"""Sorting sprites in as many goes as it takes for their records to have room."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from particlecli.render.sprites import PACK, Span, Store
from particlecli.render.tasks import CHUNK

FIRST, END, COLORS, HALO, SMEARED = range(5)
"""Columns of a table of chunks, see `Span`. Whole numbers in it are small enough for 32-bit floats."""

SMEARED_CHUNK = CHUNK // 4
"""Smeared sprites that make one task: each takes some records."""

Chunks = NDArray[np.float32]
"""Sprites that one worker sorts in one go, a row for each chunk."""

Draw = Callable[[Chunks], int]
"""Sorts and draws the sprites of some chunks; tells how many records that takes. Where the store has no room for so
many, it draws nothing."""


def draw_in_parts(spans: Sequence[Span], store: Store, bins: int, draw: Draw) -> None:
    """Draw sprites in their order, sorted into so many bins, at once if possible.

    A few sprites always have room: none takes more than a few thousand records.
    """
    most = store.most_chunks(bins)
    chunks = np.array([row for span in spans for row in _chunks(span)], np.float32)
    parts = [chunks[first : first + most] for first in range(0, len(chunks), most)]
    while parts:
        part = parts.pop(0)
        needed = draw(part)
        if needed > store.room:
            pieces = 2 * needed // store.room
            finer = part if len(part) >= pieces else np.concatenate([_cut(row, pieces) for row in part])
            parts[:0] = [finer[rows] for rows in np.array_split(np.arange(len(finer)), min(pieces, len(finer)))]


def _chunks(span: Span) -> Iterator[tuple[float, ...]]:
    size = SMEARED_CHUNK if span.smeared else CHUNK
    for first in range(span.first, span.end, size):
        yield first, min(first + size, span.end), span.colors, span.halo, span.smeared


def _cut(row: NDArray[np.float32], pieces: int) -> Chunks:
    """One chunk as several, whole packs each."""
    first, end = int(row[FIRST]), int(row[END])
    step = max(PACK, (end - first) // pieces // PACK * PACK)
    starts = np.arange(first, end, step)
    cut = np.repeat(row[None], len(starts), axis=0)
    cut[:, FIRST], cut[:, END] = starts, np.minimum(starts + step, end)
    return cut

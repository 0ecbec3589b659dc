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

Sort = Callable[[Chunks, bool], int]
"""Counts the records that sprites of some chunks make, or, once that is done, puts them in their places; tells how many
there are."""


def draw_in_parts(spans: Sequence[Span], store: Store, bins: int, sort: Sort, splat: Callable[[Chunks], None]) -> None:
    """Draw sprites in their order, sorted into so many bins, at once if the store has room for their records.

    A few sprites always have room: none takes more than a few thousand records.
    """
    most = store.most_chunks(bins)
    chunks = np.array([row for span in spans for row in _chunks(span)], np.float32)
    parts = [chunks[first : first + most] for first in range(0, len(chunks), most)]
    while parts:
        part = parts.pop(0)
        needed = sort(part, False)
        if needed > store.room:
            parts[:0] = _split(part, 2 * needed // store.room)
        else:
            sort(part, True)
            splat(part)


def _split(chunks: Chunks, pieces: int) -> list[Chunks]:
    """Chunks in several parts, of no more chunks than there were; they are cut themselves where they are fewer."""
    finer = chunks if len(chunks) >= pieces else np.concatenate([_cut(row, pieces) for row in chunks])
    parts = min(max(pieces, -(-len(finer) // len(chunks))), len(finer))
    return [finer[rows] for rows in np.array_split(np.arange(len(finer)), parts)]


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

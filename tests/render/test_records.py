from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from particlecli.render.records import END, FIRST, SMEARED, Chunks, draw_in_parts
from particlecli.render.sprites import PACK, Span
from particlecli.render.tasks import CHUNK


def drawn(spans: list[Span], *, room: int, chunks: int, records: int) -> list[Chunks]:
    """The parts that are drawn, with so many records a sprite; each part is counted and placed before."""
    store: Any = SimpleNamespace(room=room, most_chunks=lambda bins: chunks)
    sorted_: list[bool] = []
    parts: list[Chunks] = []

    def sort(part: Chunks, placing: bool) -> int:
        sorted_.append(placing)
        return int((part[:, END] - part[:, FIRST]).sum()) * records

    def splat(part: Chunks) -> None:
        assert sorted_[-2:] == [False, True]
        parts.append(part)

    draw_in_parts(spans, store, 100, sort, splat)
    return parts


SPANS = [Span(0, 3 * CHUNK + 5, 1, 0.3), Span(3 * CHUNK + PACK, 4 * CHUNK, 9, 0.2, smeared=True)]


@pytest.mark.parametrize(("room", "chunks"), [(10**9, 1000), (10**9, 2), (50_000, 1000), (PACK * 7, 3)])
def test_all_sprites_are_drawn_once_and_in_order(room: int, chunks: int) -> None:
    parts = drawn(SPANS, room=room, chunks=chunks, records=7)
    rows = [row for part in parts for row in part]
    places = [place for row in rows for place in range(int(row[FIRST]), int(row[END]))]
    assert places == [place for span in SPANS for place in range(span.first, span.end)]
    assert {(int(row[2]), bool(row[SMEARED])) for row in rows} == {(1, False), (9, True)}
    assert all(row[FIRST] % PACK == 0 for row in rows)
    assert all(len(part) <= chunks for part in parts)
    assert all(int((part[:, END] - part[:, FIRST]).sum()) * 7 <= room for part in parts)


def test_what_has_room_is_drawn_at_once() -> None:
    assert len(drawn(SPANS, room=10**9, chunks=1000, records=7)) == 1

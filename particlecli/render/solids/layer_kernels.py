"""Drawing the bodies of a picture into a layer, tile by tile, from front to back.

As bodies come from the nearest to the farthest, what they hide is hidden for good, and hidden pixels are passed by.
"""

import taichi as ti

from particlecli.render.arrays import Integers, IntegerTable, Rows
from particlecli.render.binning import begin, clear_counts
from particlecli.render.solids.draw_billboards import draw_billboard
from particlecli.render.solids.draw_strips import draw_piece, draw_triangle
from particlecli.render.solids.records import DEPTH, EXTENT, HIDES, LIGHT, LOOK, ROW, X, Y
from particlecli.render.solids.sorting import sort_by_depth, take_to_tiles, tiles_across
from particlecli.render.solids.tiles import (
    copy_tile,
    draw_speck,
    empty_tile,
    find_open,
    is_open,
    start_tile,
    tile_of,
)
from particlecli.render.tasks import CHUNK, WORKERS

BILLBOARDS, PIECES, TRIANGLES = range(3)
"""Kinds of bodies."""

DRAWN = 128
"""Bodies that are drawn into a tile before it is looked through for what they hide."""


@ti.func
def _draw(
    body, heads: ti.template(), rows: ti.template(), tile, store: ti.template(), looks: ti.template(),
    caps: ti.template(), sheets: ti.template(), kinds: ti.template(),
):  # fmt: skip
    """Draw one body, of one of the kinds that there are."""
    hides = heads[body, HIDES]
    if hides >= 0.0:
        light = ti.Vector([heads[body, LIGHT + k] for k in range(3)])
        draw_speck(
            heads[body, X], heads[body, Y], heads[body, EXTENT], heads[body, DEPTH], light, hides, tile, store
        )  # fmt: skip
    else:
        row = ti.bit_cast(heads[body, ROW], ti.i32)
        kind = ti.cast(looks[ti.cast(heads[body, LOOK], ti.i32), 0], ti.i32)
        if ti.static(BILLBOARDS in kinds):  # noqa: SIM102 - else it is compiled anyway
            if kind == BILLBOARDS:
                draw_billboard(body, row, heads, rows, tile, store, looks, caps, sheets)
        if ti.static(PIECES in kinds):  # noqa: SIM102 - else it is compiled anyway
            if kind == PIECES:
                draw_piece(body, row, heads, rows, tile, store)
        if ti.static(TRIANGLES in kinds):  # noqa: SIM102 - else it is compiled anyway
            if kind == TRIANGLES:
                draw_triangle(body, row, heads, rows, tile, store)


@ti.func
def _draw_all(
    first, end, worker, order: ti.template(), heads: ti.template(), rows: ti.template(), tile, store: ti.template(),
    still_open: ti.template(), looks: ti.template(), caps: ti.template(), sheets: ti.template(), kinds: ti.template(),
):  # fmt: skip
    """Draw a tile's bodies, until nothing behind them can be seen."""
    start = first
    while start < end:
        some = ti.min(start + DRAWN, end)
        for o in range(start, some):
            body = order[1, o]
            if is_open(worker, heads[body, X], heads[body, Y], heads[body, EXTENT], tile, still_open):
                _draw(body, heads, rows, tile, store, looks, caps, sheets, kinds)
        start = some
        if start < end:  # noqa: SIM102 - both would be computed
            if not find_open(tile, worker, store, still_open):
                start = end


@ti.kernel
def draw_bodies(
    count: ti.i32, heads: Rows, rows: Rows, counts: Integers, sorted_heads: Rows, keys: Integers, order: IntegerTable,
    digits: IntegerTable, width: ti.i32, height: ti.i32, near: ti.f32, color: ti.template(), depth: ti.template(),
    store: ti.template(), still_open: ti.template(), looks: Rows, caps: Rows, sheets: Rows, counter: Integers,
    kinds: ti.template(),
):  # fmt: skip
    """Draw bodies into an empty layer, if there is room for their heads.

    Args:
        heads, rows: see `records`.
        counts: shape ((chunks + 1) tiles + 1,), see `binning`.
        sorted_heads, keys, order: shapes (room, HEAD), (room,) and (2, room): heads by tile, their keys, and their
            order.
        digits: shape (workers, 2 DIGITS), for sorting.
        near: depth of the least key, m.
        color, depth, store, still_open: see `Fields`.
        looks: shape (looks, 5): kind of body, first texel, texels across a picture, whether it is a cap (else a sheet),
            how much it hides.
        caps, sheets: texels, see `caps` and `sheets`.
        kinds: which kinds there are.
    """
    chunks = (count + CHUNK - 1) // CHUNK
    across, down = tiles_across(width), tiles_across(height)
    tiles = across * down
    ti.loop_config(block_dim=1)
    for chunk in range(chunks):
        clear_counts(chunk, tiles, counts)
        take_to_tiles(chunk, count, heads, counts, sorted_heads, across, down, False)
    ti.loop_config(serialize=True)
    for _ in range(1):
        counter[0] = chunks if begin(chunks, tiles, counts) <= sorted_heads.shape[0] else 0
    ti.loop_config(block_dim=1)
    for chunk in range(counter[0]):
        take_to_tiles(chunk, count, heads, counts, sorted_heads, across, down, True)
    counter[0] = 0 if counts[chunks * tiles + tiles] <= sorted_heads.shape[0] else tiles
    ti.loop_config(block_dim=1)
    for worker in range(WORKERS):
        number = ti.atomic_add(counter[0], 1)
        while number < tiles:
            tile = tile_of(number, across, width, height, worker)
            first, end = counts[chunks * tiles + number], counts[chunks * tiles + number + 1]
            if first == end:
                empty_tile(tile, width, color, depth)
            else:
                start_tile(tile, worker, store, still_open)
                sort_by_depth(first, end, near, worker, sorted_heads, keys, digits, order)
                _draw_all(
                    first, end, worker, order, sorted_heads, rows, tile, store, still_open, looks, caps, sheets,
                    kinds,
                )  # fmt: skip
                copy_tile(tile, width, store, color, depth)
            number = ti.atomic_add(counter[0], 1)

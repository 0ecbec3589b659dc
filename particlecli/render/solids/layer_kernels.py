"""Sorting bodies by the tiles that they touch, drawing them from front to back, and laying them into a picture.

Each tile is drawn by one worker in a store of its own, so small that it stays in the nearest cache.
The layer holds for each pixel the light of bodies, and the share of what is behind them that is still seen. As
bodies come from the nearest to the farthest, what they hide is hidden for good, and hidden pixels are passed by.
"""

import taichi as ti

from particlecli.render.arrays import Integers, IntegerTable, Rows, Shorts, vec4
from particlecli.render.binning import begin, clear_counts
from particlecli.render.solids.draw import (
    FAINT,
    TILE,
    Tile,
    between,
    draw_billboard,
    draw_piece,
    draw_triangle,
)
from particlecli.render.solids.records import EXTENT, LOOK, X, Y
from particlecli.render.sprites import ENERGY, PACK, SEEN
from particlecli.render.tasks import CHUNK, GRAIN, LANES

BILLBOARDS, PIECES, TRIANGLES = range(3)
"""Kinds of bodies."""

FAR = 1e30
"""Depth where nothing is."""


TILE_NODES = TILE * TILE
"""Nodes of a worker's tile."""

DRAWN = 128
"""Bodies that are drawn into a tile before it is looked through for what they hide."""

DIGITS = 256
"""Keys are sorted by two digits of 8 bits."""

FEW = 24
"""Records that are sorted by insertion."""


@ti.func
def _tiles(size):
    """How many tiles cover so many pixels."""
    return (size + TILE - 1) // TILE


@ti.func
def _touched(middle, extent, tiles):
    """First tile, and the one behind the last, along an axis that something touches; the same where it touches none."""
    first = ti.max(ti.cast(ti.floor((middle - extent) * (1.0 / TILE)), ti.i32), 0)
    end = ti.min(ti.cast(ti.floor((middle + extent) * (1.0 / TILE)), ti.i32) + 1, tiles)
    return first, ti.max(first, end)


@ti.func
def _count(chunk, count, rows: ti.template(), boxes: ti.template(), counts: ti.template(), across, down):
    """Count a chunk's bodies by the tiles that they touch, and keep which these are."""
    start = chunk * across * down
    for row in range(chunk * CHUNK, ti.min(count, chunk * CHUNK + CHUNK)):
        extent, left, right, top, bottom = rows[row, EXTENT], 0, 0, 0, 0
        if extent > 0.0:
            left, right = _touched(rows[row, X], extent, across)
            top, bottom = _touched(rows[row, Y], extent, down)
        boxes[row, 0], boxes[row, 1] = left | (right << 16), top | (bottom << 16)
        for y in range(top, bottom):
            for x in range(left, right):
                tile = start + y * across + x
                counts[tile] = counts[tile] + 1


@ti.func
def _place(
    chunk, count, rows: ti.template(), boxes: ti.template(), keys: ti.template(), counts: ti.template(),
    records: ti.template(), across, down, numbers: ti.template(),
):  # fmt: skip
    """Copy the rows of a chunk's bodies, and behind each its key, to where the counts say."""
    start = chunk * across * down
    for row in range(chunk * CHUNK, ti.min(count, chunk * CHUNK + CHUNK)):
        columns, lines = boxes[row, 0], boxes[row, 1]
        for y in range(lines & 0xFFFF, lines >> 16):
            for x in range(columns & 0xFFFF, columns >> 16):
                tile = start + y * across + x
                place = counts[tile]
                counts[tile] = place + 1
                records[place, numbers] = ti.cast(keys[row], ti.f32)
                for k in ti.static(range(numbers)):
                    records[place, k] = rows[row, k]


@ti.func
def _sort_few(first, end, records: ti.template(), keys: ti.template(), order: ti.template(), numbers: ti.template()):
    """Sort a few records by insertion; see `_sort`."""
    for o in range(first, end):
        key = ti.cast(records[o, numbers], ti.i32)
        keys[o] = key
        place = o
        while place > first and keys[order[1, place - 1]] > key:
            order[1, place] = order[1, place - 1]
            place -= 1
        order[1, place] = o


@ti.func
def _sort(
    first, end, worker, records: ti.template(), keys: ti.template(), digits: ti.template(), order: ti.template(),
    numbers: ti.template(),
):  # fmt: skip
    """Sort a tile's records from near to far; those of the same key keep their order. The result is in order[1].

    The keys are read out of the records, one after the other: so these come into the cache faster than if they came
    in the order of their depths.
    """
    for digit in range(2 * DIGITS):
        digits[worker, digit] = 0
    for o in range(first, end):
        key = ti.cast(records[o, numbers], ti.i32)
        keys[o] = key
        low, high = key & (DIGITS - 1), DIGITS + (key >> 8)
        digits[worker, low] = digits[worker, low] + 1
        digits[worker, high] = digits[worker, high] + 1
    low, high = first, first
    for digit in range(DIGITS):
        here, there = digits[worker, digit], digits[worker, DIGITS + digit]
        digits[worker, digit], digits[worker, DIGITS + digit] = low, high
        low, high = low + here, high + there
    for o in range(first, end):
        digit = keys[o] & (DIGITS - 1)
        place = digits[worker, digit]
        digits[worker, digit] = place + 1
        order[0, place] = o
    for o in range(first, end):
        record = order[0, o]
        digit = DIGITS + (keys[record] >> 8)
        place = digits[worker, digit]
        digits[worker, digit] = place + 1
        order[1, place] = record


@ti.func
def _clear(worker, color: ti.template(), depth: ti.template(), still_open: ti.template()):
    """Empty a worker's tile."""
    for node in range(worker * TILE_NODES, (worker + 1) * TILE_NODES):
        color[node] = vec4(0.0, 0.0, 0.0, 1.0)
        depth[node] = FAR
    for line in range(TILE):
        still_open[worker, line] = ti.u32(0xFFFFFFFF)


@ti.func
def _empty(tile, width, color: ti.template(), depth: ti.template()):
    """Empty the place of a tile in the layer."""
    for line in range(tile.top, tile.bottom):
        for node in range(line * width + tile.left, line * width + tile.right):
            color[node] = vec4(0.0, 0.0, 0.0, 1.0)
            depth[node] = FAR


@ti.func
def _find_open(worker, tile, color: ti.template(), still_open: ti.template()):
    """Find out behind which pixels of a worker's tile something can still be seen; returns whether there are any."""
    within = ti.u32(0xFFFFFFFF) >> ti.cast(TILE - (tile.right - tile.left), ti.u32)
    anywhere = ti.u32(0)
    for line in range(tile.bottom - tile.top):
        bits = ti.u32(0)
        for column in ti.static(range(TILE)):
            through = color[worker * TILE_NODES + line * TILE + column][3]
            bits = bits | ti.select(through > FAINT, ti.u32(1 << column), ti.u32(0))
        still_open[worker, line] = bits
        anywhere = anywhere | (bits & within)
    return anywhere != 0


@ti.func
def _is_open(worker, x, y, extent, tile, still_open: ti.template()):
    """Whether some of a square can be seen."""
    left, right = between(x, extent, tile.left, tile.right)
    top, bottom = between(y, extent, tile.top, tile.bottom)
    found = ti.u32(0)
    if right > left:
        span = (ti.u32(0xFFFFFFFF) >> ti.cast(TILE - (right - left), ti.u32)) << ti.cast(left - tile.left, ti.u32)
        for line in range(top - tile.top, bottom - tile.top):
            found = found | (still_open[worker, line] & span)
    return found != 0


@ti.func
def _copy(
    tile, width, tile_color: ti.template(), tile_depth: ti.template(), color: ti.template(), depth: ti.template()
):  # fmt: skip
    """Take a worker's tile to its place in the layer."""
    for line in range(tile.top, tile.bottom):
        for column in range(tile.left, tile.right):
            node = tile.origin + line * TILE + column
            color[line * width + column] = tile_color[node]
            depth[line * width + column] = tile_depth[node]


@ti.kernel
def draw_bodies(
    count: ti.i32, rows: Rows, keys: Shorts, boxes: IntegerTable, counts: Integers, records: Rows,
    record_keys: Integers, order: IntegerTable, digits: IntegerTable, width: ti.i32, height: ti.i32,
    color: ti.template(), depth: ti.template(), tile_color: ti.template(), tile_depth: ti.template(),
    still_open: ti.template(), looks: Rows, caps: Rows, sheets: Rows, counter: Integers, kinds: ti.template(),
    numbers: ti.template(),
):  # fmt: skip
    """Draw bodies into an empty layer, if there is room for their records.

    Args:
        rows, keys: see `records`.
        boxes: shape (room, 2): the first and the end of the tiles that a body touches, across and down.
        counts: shape ((chunks + 1) tiles + 1,), see `binning`.
        records, record_keys, order: shapes (room, numbers + 1), (room,) and (2, room): rows with their keys by tile,
            the keys alone, and the order of the rows.
        digits: shape (workers, 2 DIGITS), for sorting.
        color, depth, tile_color, tile_depth, still_open: see `Fields`.
        looks: shape (looks, 5): kind of body, first texel, texels across a picture, whether it is a cap (else a sheet),
            how much it hides.
        caps, sheets: texels, see `caps` and `sheets`.
        kinds: which kinds there are.
        numbers: how many a row has.
    """
    chunks = (count + CHUNK - 1) // CHUNK
    across, down = _tiles(width), _tiles(height)
    tiles = across * down
    counter[0] = 0
    for lane in range(LANES):
        if lane % GRAIN == 0:
            chunk = ti.atomic_add(counter[0], 1)
            while chunk < chunks:
                clear_counts(chunk, tiles, counts)
                _count(chunk, count, rows, boxes, counts, across, down)
                chunk = ti.atomic_add(counter[0], 1)
    ti.loop_config(serialize=True)
    for _ in range(1):
        counter[0] = 0 if begin(chunks, tiles, counts) <= records.shape[0] else chunks
    for lane in range(LANES):
        if lane % GRAIN == 0:
            chunk = ti.atomic_add(counter[0], 1)
            while chunk < chunks:
                _place(chunk, count, rows, boxes, keys, counts, records, across, down, numbers)
                chunk = ti.atomic_add(counter[0], 1)
    counter[0] = 0 if counts[chunks * tiles + tiles] <= records.shape[0] else tiles
    for lane in range(LANES):
        if lane % GRAIN == 0:
            number = ti.atomic_add(counter[0], 1)
            while number < tiles:
                worker, left, top = lane // GRAIN, number % across * TILE, number // across * TILE
                tile = Tile(
                    left=left,
                    top=top,
                    right=ti.min(left + TILE, width),
                    bottom=ti.min(top + TILE, height),
                    origin=worker * TILE_NODES - top * TILE - left,
                )
                first, end = counts[chunks * tiles + number], counts[chunks * tiles + number + 1]
                if first == end:
                    _empty(tile, width, color, depth)
                else:
                    _clear(worker, tile_color, tile_depth, still_open)
                if end - first > FEW:
                    _sort(first, end, worker, records, record_keys, digits, order, numbers)
                else:
                    _sort_few(first, end, records, record_keys, order, numbers)
                filled = first < end
                while first < end:
                    some = ti.min(first + DRAWN, end)
                    for o in range(first, some):
                        row = order[1, o]
                        x, y, extent = records[row, X], records[row, Y], records[row, EXTENT]
                        if _is_open(worker, x, y, extent, tile, still_open):
                            look = ti.cast(records[row, LOOK], ti.i32)
                            kind = ti.cast(looks[look, 0], ti.i32)
                            if ti.static(BILLBOARDS in kinds):  # noqa: SIM102 - else it is compiled anyway
                                if kind == BILLBOARDS:
                                    draw_billboard(
                                        row, look, records, tile, tile_color, tile_depth, looks, caps, sheets
                                    )
                            if ti.static(PIECES in kinds):  # noqa: SIM102 - else it is compiled anyway
                                if kind == PIECES:
                                    draw_piece(row, records, tile, tile_color, tile_depth)
                            if ti.static(TRIANGLES in kinds):  # noqa: SIM102 - else it is compiled anyway
                                if kind == TRIANGLES:
                                    draw_triangle(row, records, tile, tile_color, tile_depth)
                    first = some
                    if first < end:  # noqa: SIM102 - both would be computed
                        if not _find_open(worker, tile, tile_color, still_open):
                            first = end
                if filled:
                    _copy(tile, width, tile_color, tile_depth, color, depth)
                number = ti.atomic_add(counter[0], 1)


@ti.kernel
def lay(
    color: ti.template(), light: ti.template(), counter: Integers, origin: ti.i32, pitch: ti.i32, width: ti.i32,
    height: ti.i32, exposed_open: Rows, cover: Rows,
):  # fmt: skip
    """Lay a layer over the light of a picture, and over how much of the sky and of the ground is seen in it."""
    counter[0] = 0
    for lane in range(LANES):
        if lane % GRAIN == 0:
            y = ti.atomic_add(counter[0], 1)
            while y < height:
                for x in range(width):
                    body = color[y * width + x]
                    node = origin + y * pitch + x
                    light[node] = light[node] * body[3] + vec4(body[0], body[1], body[2], 0.0)
                    exposed_open[y, x] = exposed_open[y, x] * body[3]
                    cover[y, x] = cover[y, x] * body[3]
                y = ti.atomic_add(counter[0], 1)


@ti.kernel
def hide(
    first: ti.i32, count: ti.i32, positions: Rows, origin_x: ti.f32, origin_y: ti.f32, origin_z: ti.f32,
    forward_x: ti.f32, forward_y: ti.f32, forward_z: ti.f32, width: ti.i32, height: ti.i32,
    color: ti.template(), depth: ti.template(), sprites: ti.template(), counter: Integers,
):  # fmt: skip
    """Dim sprites of light that are behind bodies."""
    counter[0] = 0
    for lane in range(LANES):
        if lane % GRAIN == 0:
            chunk = ti.atomic_add(counter[0], 1)
            while chunk * CHUNK < count:
                for k in range(chunk * CHUNK, ti.min(count, chunk * CHUNK + CHUNK)):
                    i = first + k
                    away = (
                        (positions[0, i] - origin_x) * forward_x
                        + (positions[1, i] - origin_y) * forward_y
                        + (positions[2, i] - origin_z) * forward_z
                    )
                    b, at = k // PACK, k % PACK
                    x = ti.min(ti.max(sprites[SEEN, X, b][at] + 0.5, 0.0), width - 1.0)
                    y = ti.min(ti.max(sprites[SEEN, Y, b][at] + 0.5, 0.0), height - 1.0)
                    node = ti.cast(y, ti.i32) * width + ti.cast(x, ti.i32)
                    if away > depth[node]:
                        sprites[SEEN, ENERGY, b][at] = sprites[SEEN, ENERGY, b][at] * color[node][3]
                chunk = ti.atomic_add(counter[0], 1)

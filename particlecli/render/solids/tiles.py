"""Tiles of a layer: each is drawn by one worker in a store of its own, so small that it stays in the nearest cache.

A store holds for each pixel the light of bodies, the share of what is behind them that is still seen, and the depth of
what hides half of it; PACK pixels beside each other are taken at once.
"""

import taichi as ti

from particlecli.render.arrays import vec3, vec4

TILE = 32
"""Pixels across a tile."""

PACK = 8
PACKS = TILE // PACK
"""Of a line of a tile."""

TILE_PACKS = TILE * PACKS

LIT, THROUGH, AWAY = 0, 3, 4
"""What is kept for a pixel: light, three numbers; share that is still seen; and depth, m."""

KEPT = 5

FAR = 1e30
"""Depth where nothing is."""

FAINT = 1 / 400
"""What is behind bodies that let less through is not drawn."""

Single = ti.types.vector(PACK, ti.f32)

Tile = ti.types.struct(
    left=ti.i32,  # first column and row on the picture, and those behind the last
    top=ti.i32,
    right=ti.i32,
    bottom=ti.i32,
    first=ti.i32,  # pack in the stores
)


@ti.func
def tile_of(number, across, width, height, worker):
    """One of a picture's tiles, of which there are so many `across`."""
    left, top = number % across * TILE, number // across * TILE
    return Tile(
        left=left,
        top=top,
        right=ti.min(left + TILE, width),
        bottom=ti.min(top + TILE, height),
        first=worker * TILE_PACKS,
    )


@ti.func
def between(middle, reach, first, end):
    """The first pixel, and the one behind the last, of those from `first` to before `end` that lie within reach."""
    return (
        ti.max(ti.cast(ti.ceil(middle - reach), ti.i32), first),
        ti.min(ti.cast(ti.floor(middle + reach), ti.i32) + 1, end),
    )


@ti.func
def start_tile(tile, worker, store: ti.template(), still_open: ti.template()):
    """Empty a worker's tile."""
    for pack in range(tile.first, tile.first + TILE_PACKS):
        for k in ti.static(range(3)):
            store[pack, LIT + k] = Single(0.0)
        store[pack, THROUGH] = Single(1.0)
        store[pack, AWAY] = Single(FAR)
    for line in range(TILE):
        still_open[worker, line] = ti.u32(0xFFFFFFFF)


@ti.func
def find_open(tile, worker, store: ti.template(), still_open: ti.template()):
    """Find out behind which pixels of a worker's tile something can still be seen; returns whether there are any."""
    within = ti.u32(0xFFFFFFFF) >> ti.cast(TILE - (tile.right - tile.left), ti.u32)
    anywhere = ti.u32(0)
    for line in range(tile.bottom - tile.top):
        bits = ti.u32(0)
        for pack in ti.static(range(PACKS)):
            through = store[tile.first + line * PACKS + pack, THROUGH]
            for k in ti.static(range(PACK)):
                bits = bits | ti.select(through[k] > FAINT, ti.u32(1 << (pack * PACK + k)), ti.u32(0))
        still_open[worker, line] = bits
        anywhere = anywhere | (bits & within)
    return anywhere != 0


@ti.func
def is_open(worker, x, y, extent, tile, still_open: ti.template()):
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
def place_in(tile, column, line):
    """Where a pixel of the picture is in a store: its pack, and its place there."""
    beside = column - tile.left
    return tile.first + (line - tile.top) * PACKS + beside // PACK, beside % PACK


@ti.func
def cover(tile, column, line, z, light, alpha, store: ti.template()):
    """Put light that hides `alpha` of what is behind it behind what is at a pixel already."""
    pack, at = place_in(tile, column, line)
    seen = store[pack, THROUGH][at]
    left_over = seen * (1.0 - alpha)
    for k in ti.static(range(3)):
        store[pack, LIT + k][at] = store[pack, LIT + k][at] + light[k] * seen
    store[pack, THROUGH][at] = seen - alpha * seen
    if (seen >= 0.5) & (left_over < 0.5):
        store[pack, AWAY][at] = z


@ti.func
def can_be_seen(tile, column, line, store: ti.template()):
    """Whether what is behind a pixel can be seen."""
    pack, at = place_in(tile, column, line)
    return store[pack, THROUGH][at] > FAINT


@ti.func
def packs_between(left, right, tile):
    """The first pack of a line, and the one behind the last, that columns from `left` to before `right` are in."""
    return (left - tile.left) // PACK, (right - tile.left + PACK - 1) // PACK


@ti.func
def beside(pack, x, tile):
    """How far the pixels of a pack of a line are to the right of x."""
    return ti.Vector([ti.cast(k, ti.f32) for k in range(PACK)]) + (tile.left + pack * PACK - x)


@ti.func
def pack_at(pack, line, tile):
    """Place of a pack of a line in a store."""
    return tile.first + (line - tile.top) * PACKS + pack


@ti.func
def cover_pack(place, z, light: ti.template(), hides, store: ti.template()):
    """Put light, a pack for each of its numbers, that hides some of what is behind it behind what is there already."""
    seen = store[place, THROUGH]
    shown = ti.select(seen > FAINT, seen, 0.0)
    left_over = seen - hides * shown
    store[place, AWAY] = ti.select((seen >= 0.5) & (left_over < 0.5), z, store[place, AWAY])
    store[place, THROUGH] = left_over
    for k in ti.static(range(3)):
        store[place, LIT + k] = store[place, LIT + k] + light[k] * shown


@ti.func
def draw_speck(x, y, reach, z, light: vec3, alpha, tile, store: ti.template()):
    """Draw a disc of one colour, whose antialiased edge ends at `reach`."""
    left, right = between(x, reach, tile.left, tile.right)
    top, bottom = between(y, reach, tile.top, tile.bottom)
    first, end = packs_between(left, right, tile)
    for pack in range(first, end):
        dx = beside(pack, x, tile)
        for line in range(top, bottom):
            dy = line - y
            covered = ti.min(ti.max(reach - ti.sqrt(dx * dx + dy * dy), 0.0), 1.0)
            lit = [light[k] * covered for k in ti.static(range(3))]
            cover_pack(pack_at(pack, line, tile), z, lit, alpha * covered, store)


@ti.func
def copy_tile(tile, width, store: ti.template(), color: ti.template(), depth: ti.template()):
    """Take a worker's tile to its place in the layer."""
    for line in range(tile.top, tile.bottom):
        for column in range(tile.left, tile.right):
            pack, at = place_in(tile, column, line)
            color[line * width + column] = vec4(
                store[pack, LIT][at], store[pack, LIT + 1][at], store[pack, LIT + 2][at], store[pack, THROUGH][at]
            )
            depth[line * width + column] = store[pack, AWAY][at]


@ti.func
def empty_tile(tile, width, color: ti.template(), depth: ti.template()):
    """Empty the place of a tile in the layer."""
    for line in range(tile.top, tile.bottom):
        for node in range(line * width + tile.left, line * width + tile.right):
            color[node] = vec4(0.0, 0.0, 0.0, 1.0)
            depth[node] = FAR

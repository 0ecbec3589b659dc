"""Drawing a billboard into a tile: a disc with the shading of a cap, or a square with a picture of a sheet."""

import taichi as ti

from particlecli.render.arrays import vec3, vec4
from particlecli.render.solids.records import (
    ALPHA,
    BLUE,
    BLUR,
    COSINE,
    DEPTH,
    EXTENT,
    GREEN,
    LOOK,
    PICTURE,
    RADIUS,
    RED,
    SINE,
    X,
    Y,
)
from particlecli.render.solids.tiles import (
    FAINT,
    PACK,
    THROUGH,
    Single,
    beside,
    between,
    cover_pack,
    pack_at,
    packs_between,
)

SMALLEST = 0.7
"""Smaller billboards are drawn with this radius, pixels, and hide accordingly less."""

RIM = 0.985
"""Caps are looked up no further out than this share of their radius."""


@ti.func
def drawn_as(sharp, blur, alpha):
    """Radius that a billboard is drawn with, pixels, and how much it hides, as what it hides in all stays the same."""
    radius = ti.max(ti.max(sharp, blur), SMALLEST)
    return radius, alpha * (sharp / radius) * (sharp / radius)


@ti.func
def _four(texels: ti.template(), place, column: ti.template()):
    return vec4(texels[place, column], texels[place, column + 1], texels[place, column + 2], texels[place, column + 3])


@ti.func
def _level(texels, radius):
    """Of a picture's levels, each half as fine, the one with about a texel a pixel, and its first texel and size."""
    level, size, start = 0, texels, 0
    while (size > 2.8 * radius) & (size > 2):
        start += size * size
        size = size // 2
        level += 1
    return start, size


@ti.func
def _bilinear(table: ti.template(), first, size, u, v, column: ti.template()):
    """A picture at u, v in −1..1; u to the right, v down."""
    x = ti.min(ti.max((u * 0.5 + 0.5) * size - 0.5, 0.0), size - 1.001)
    y = ti.min(ti.max((v * 0.5 + 0.5) * size - 0.5, 0.0), size - 1.001)
    i, j = ti.cast(x, ti.i32), ti.cast(y, ti.i32)
    s, t = x - i, y - j
    place = first + j * size + i
    upper = _four(table, place, column) * (1.0 - s) + _four(table, place + 1, column) * s
    lower = _four(table, place + size, column) * (1.0 - s) + _four(table, place + size + 1, column) * s
    return upper * (1.0 - t) + lower * t


@ti.func
def _nearest(table: ti.template(), first, size, u, v, column: ti.template()):
    i = ti.min(ti.max(ti.cast((u * 0.5 + 0.5) * size, ti.i32), 0), size - 1)
    j = ti.min(ti.max(ti.cast((v * 0.5 + 0.5) * size, ti.i32), 0), size - 1)
    return _four(table, first + j * size + i, column)


@ti.func
def _shaded(caps: ti.template(), first, size, fine, u, v, tint):
    """Light of a cap at u, v in −1..1, and how much it hides."""
    lit, gloss = vec4(0.0), vec4(0.0)
    if fine:
        lit = _bilinear(caps, first, size, u, v, 0)
        gloss = _bilinear(caps, first, size, u, v, 4)
    else:
        lit = _nearest(caps, first, size, u, v, 0)
        gloss = _nearest(caps, first, size, u, v, 4)
    return vec3(lit[0] * tint[0] + gloss[0], lit[1] * tint[1] + gloss[1], lit[2] * tint[2] + gloss[2]), lit[3]


@ti.func
def _ball(x, y, radius, blur, z, tint, alpha, first, size, tile, caps: ti.template(), store: ti.template()):
    """Draw a disc with the shading of a cap."""
    ramp = 1.0 / (1.0 + 2.0 * ti.min(blur, radius))
    reach, inner, fine = radius + 0.5 / ramp, 1.0 / radius, size < 1.5 * radius
    top, bottom = between(y, reach, tile.top, tile.bottom)
    for line in range(top, bottom):
        dy = line - y
        left, right = between(x, ti.sqrt(ti.max(reach * reach - dy * dy, 0.0)), tile.left, tile.right)
        first_pack, end = packs_between(left, right, tile)
        for pack in range(first_pack, end):
            place, dx = pack_at(pack, line, tile), beside(pack, x, tile)
            distance = ti.sqrt(dx * dx + dy * dy)
            covered = alpha * ti.min(ti.max((radius - distance) * ramp + 0.5, 0.0), 1.0)
            covered = ti.select(store[place, THROUGH] > FAINT, covered, 0.0)
            shrunk = inner * ti.min(1.0, RIM * radius / ti.max(distance, 1e-6))
            u, v = dx * shrunk, dy * shrunk
            red, green, blue, hidden = Single(0.0), Single(0.0), Single(0.0), Single(0.0)
            for k in ti.static(range(PACK)):
                if covered[k] > 0.0:
                    light, hidden[k] = _shaded(caps, first, size, fine, u[k], v[k], tint)
                    red[k], green[k], blue[k] = light[0], light[1], light[2]
            cover_pack(place, z, [red * covered, green * covered, blue * covered], hidden * covered, store)


@ti.func
def _picture(
    x, y, radius, extent, z, tint, alpha, hides, c, s, first, size, tile, sheets: ti.template(), store: ti.template()
):  # fmt: skip
    """Draw a square with a picture of a sheet, turned by an angle of cosine c and sine s."""
    inner = 1.0 / radius
    left, right = between(x, extent, tile.left, tile.right)
    top, bottom = between(y, extent, tile.top, tile.bottom)
    first_pack, end = packs_between(left, right, tile)
    for pack in range(first_pack, end):
        dx = beside(pack, x, tile)
        for line in range(top, bottom):
            dy = line - y
            place = pack_at(pack, line, tile)
            u, v = (dx * c + dy * s) * inner, (dy * c - dx * s) * inner
            edge = ti.min(ti.max((1.0 - ti.max(ti.abs(u), ti.abs(v))) * radius + 0.5, 0.0), 1.0)
            some = ti.select(store[place, THROUGH] > FAINT, edge, 0.0) * alpha
            red, green, blue, hidden = Single(0.0), Single(0.0), Single(0.0), Single(0.0)
            for k in ti.static(range(PACK)):
                if some[k] > 0.0:
                    texel = _bilinear(sheets, first, size, u[k], v[k], 0) * some[k]
                    red[k], green[k], blue[k], hidden[k] = texel[0], texel[1], texel[2], texel[3]
            cover_pack(place, z, [red * tint[0], green * tint[1], blue * tint[2]], hidden * hides, store)


@ti.func
def draw_billboard(
    body, row, heads: ti.template(), rows: ti.template(), tile, store: ti.template(), looks: ti.template(),
    caps: ti.template(), sheets: ti.template(),
):  # fmt: skip
    """Draw a disc with the shading of a cap, or a square with a picture of a sheet."""
    x, y, z, extent = heads[body, X], heads[body, Y], heads[body, DEPTH], heads[body, EXTENT]
    look, blur = ti.cast(heads[body, LOOK], ti.i32), rows[row, BLUR]
    radius, alpha = drawn_as(rows[row, RADIUS], blur, rows[row, ALPHA])
    tint = vec3(rows[row, RED], rows[row, GREEN], rows[row, BLUE])
    first, texels = ti.cast(looks[look, 1], ti.i32), ti.cast(looks[look, 2], ti.i32)
    start, size = _level(texels, radius / (1.0 + blur))
    if looks[look, 3] > 0.5:
        _ball(x, y, radius, blur, z, tint, alpha, first + start, size, tile, caps, store)
    else:
        first += ti.cast(rows[row, PICTURE], ti.i32) * ((4 * texels * texels - 1) // 3)
        _picture(
            x, y, radius, extent, z, tint, alpha, looks[look, 4], rows[row, COSINE], rows[row, SINE], first + start,
            size, tile, sheets, store,
        )  # fmt: skip

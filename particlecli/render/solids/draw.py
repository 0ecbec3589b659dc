"""Drawing one body into a tile of a layer, in front of which nearer bodies are already."""

import taichi as ti

from particlecli.render.arrays import vec2, vec3, vec4
from particlecli.render.solids.records import (
    ALPHA,
    BLUE,
    BLUR,
    CORNERS,
    COSINE,
    DEPTH,
    EDGES,
    END_X,
    END_Y,
    EXTENT,
    FIRST_X,
    FIRST_Y,
    FROM_RED,
    GREEN,
    HALF,
    HIDES,
    OPACITY,
    PICTURE,
    RADIUS,
    RED,
    SECOND_X,
    SECOND_Y,
    SINE,
    TO_RED,
    X,
    Y,
)

TILE = 32
"""Pixels across a tile."""

Tile = ti.types.struct(
    left=ti.i32,  # first column and row on the picture, and those behind the last
    top=ti.i32,
    right=ti.i32,
    bottom=ti.i32,
    origin=ti.i32,  # node of the picture's first pixel, if it was in the tile
)

FAINT = 1 / 400
"""What is behind bodies that let less through is not drawn."""

SMALLEST = 0.7
"""Smaller billboards are drawn with this radius, pixels, and hide accordingly less."""

SMALL, SMALL_PICTURE = 1.6, 2.2
"""Balls and pictures of a smaller radius, pixels, have one colour."""

SQUARE = 4 / 3.14159265
"""A square is so much larger than the disc in it."""

RIM = 0.985
"""Caps are looked up no further out than this share of their radius."""

THIN = 0.5
"""Ribbons of less than half this width, pixels, likewise."""

ROUND = 1.5
"""Pieces of ribbons that are wider than twice this have round ends, so that bends have no gaps, pixels."""


@ti.func
def _over(node, here, z, light, alpha, color: ti.template(), depth: ti.template()):
    """Put light that hides `alpha` of what is behind it behind what is there already, which is `here`."""
    through = here[3] * (1.0 - alpha)
    color[node] = here + vec4(light[0], light[1], light[2], -alpha) * here[3]
    if (here[3] >= 0.5) & (through < 0.5):
        depth[node] = z


@ti.func
def between(middle, reach, first, end):
    """The first pixel, and the one behind the last, of those from `first` to before `end` that lie within reach."""
    return (
        ti.max(ti.cast(ti.ceil(middle - reach), ti.i32), first),
        ti.min(ti.cast(ti.floor(middle + reach), ti.i32) + 1, end),
    )


@ti.func
def _ramp(t):
    return ti.min(ti.max(t, 0.0), 1.0)


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
def _speck(x, y, radius, z, light, alpha, tile, color: ti.template(), depth: ti.template()):
    """Draw a disc of one colour."""
    reach = radius + 0.5
    left, right = between(x, reach, tile.left, tile.right)
    top, bottom = between(y, reach, tile.top, tile.bottom)
    for line in range(top, bottom):
        dy = line - y
        for column in range(left, right):
            dx = column - x
            node = tile.origin + line * TILE + column
            here = color[node]
            distance = dx * dx + dy * dy
            if (here[3] > FAINT) & (distance < reach * reach):
                covered = _ramp(reach - ti.sqrt(distance))
                _over(node, here, z, light * covered, alpha * covered, color, depth)


@ti.func
def _ball(
    x, y, radius, blur, z, tint, alpha, first, size, tile, caps: ti.template(), color: ti.template(),
    depth: ti.template(),
):  # fmt: skip
    """Draw a disc with the shading of a cap."""
    ramp = 1.0 / (1.0 + 2.0 * ti.min(blur, radius))
    reach, inner, fine = radius + 0.5 / ramp, 1.0 / radius, size < 1.5 * radius
    top, bottom = between(y, reach, tile.top, tile.bottom)
    for line in range(top, bottom):
        dy = line - y
        half = ti.sqrt(ti.max(reach * reach - dy * dy, 0.0))
        left, right = between(x, half, tile.left, tile.right)
        for column in range(left, right):
            node = tile.origin + line * TILE + column
            here = color[node]
            if here[3] > FAINT:
                dx = column - x
                distance = ti.sqrt(dx * dx + dy * dy)
                covered = alpha * _ramp((radius - distance) * ramp + 0.5)
                shrunk = inner * ti.min(1.0, RIM * radius / ti.max(distance, 1e-6))
                u, v = dx * shrunk, dy * shrunk
                lit, gloss = vec4(0.0), vec4(0.0)
                if fine:
                    lit = _bilinear(caps, first, size, u, v, 0)
                    gloss = _bilinear(caps, first, size, u, v, 4)
                else:
                    lit = _nearest(caps, first, size, u, v, 0)
                    gloss = _nearest(caps, first, size, u, v, 4)
                light = vec3(lit[0] * tint[0] + gloss[0], lit[1] * tint[1] + gloss[1], lit[2] * tint[2] + gloss[2])
                _over(node, here, z, light * covered, lit[3] * covered, color, depth)


@ti.func
def _picture(
    x, y, radius, extent, z, tint, alpha, hides, c, s, first, size, tile, sheets: ti.template(),
    color: ti.template(), depth: ti.template(),
):  # fmt: skip
    """Draw a square with a picture of a sheet, turned by an angle of cosine c and sine s."""
    inner = 1.0 / radius
    left, right = between(x, extent, tile.left, tile.right)
    top, bottom = between(y, extent, tile.top, tile.bottom)
    for line in range(top, bottom):
        dy = line - y
        for column in range(left, right):
            dx = column - x
            u, v = (dx * c + dy * s) * inner, (dy * c - dx * s) * inner
            edge = _ramp((1.0 - ti.max(ti.abs(u), ti.abs(v))) * radius + 0.5)
            node = tile.origin + line * TILE + column
            here = color[node]
            if (here[3] > FAINT) & (edge > 0.0):
                texel = _bilinear(sheets, first, size, u, v, 0) * (alpha * edge)
                light = vec3(texel[0] * tint[0], texel[1] * tint[1], texel[2] * tint[2])
                _over(node, here, z, light, texel[3] * hides, color, depth)


@ti.func
def draw_billboard(
    row, look, rows: ti.template(), tile, color: ti.template(), depth: ti.template(), looks: ti.template(),
    caps: ti.template(), sheets: ti.template(),
):  # fmt: skip
    """Draw a disc with the shading of a cap, or a square with a picture of a sheet; of small ones the mean colour."""
    x, y, z, extent, blur = (
        rows[row, X],
        rows[row, Y],
        rows[row, DEPTH],
        rows[row, EXTENT],
        rows[row, BLUR],
    )
    sharp = rows[row, RADIUS]
    radius = ti.max(ti.max(sharp, blur), SMALLEST)
    alpha = rows[row, ALPHA] * (sharp / radius) * (sharp / radius)
    tint = vec3(rows[row, RED], rows[row, GREEN], rows[row, BLUE])
    texels, is_ball, hides = ti.cast(looks[look, 2], ti.i32), looks[look, 3] > 0.5, looks[look, 4]
    first, all_levels = ti.cast(looks[look, 1], ti.i32), (4 * texels * texels - 1) // 3
    if not is_ball:
        first += ti.cast(rows[row, PICTURE], ti.i32) * all_levels
    if radius < ti.select(is_ball, SMALL, SMALL_PICTURE):
        light, hidden = vec3(0.0), 0.0
        if is_ball:
            lit, gloss = _four(caps, first + all_levels - 1, 0), _four(caps, first + all_levels - 1, 4)
            light = vec3(lit[0] * tint[0] + gloss[0], lit[1] * tint[1] + gloss[1], lit[2] * tint[2] + gloss[2]) * alpha
            hidden = lit[3] * alpha
        else:
            texel = _four(sheets, first + all_levels - 1, 0) * (alpha * SQUARE)
            light = vec3(texel[0] * tint[0], texel[1] * tint[1], texel[2] * tint[2])
            hidden = ti.min(texel[3], 1.0) * hides
        _speck(x, y, radius, z, light, hidden, tile, color, depth)
    else:
        start, size = _level(texels, radius / (1.0 + blur))
        if is_ball:
            _ball(x, y, radius, blur, z, tint, alpha, first + start, size, tile, caps, color, depth)
        else:
            _picture(
                x, y, radius, extent, z, tint, alpha, hides, rows[row, COSINE], rows[row, SINE], first + start, size,
                tile, sheets, color, depth,
            )  # fmt: skip


@ti.func
def draw_piece(row, rows: ti.template(), tile, color: ti.template(), depth: ti.template()):
    """Draw a straight piece of a ribbon, bright along its middle as a thread is."""
    x, y, reach = rows[row, X], rows[row, Y], rows[row, EXTENT]
    along = vec2(rows[row, END_X], rows[row, END_Y])
    half = ti.max(rows[row, HALF], THIN)
    alpha = rows[row, HIDES] * ti.min(rows[row, HALF] / THIN, 1.0)
    square = ti.max(along.dot(along), 1e-8)
    start = vec3(rows[row, FROM_RED], rows[row, FROM_RED + 1], rows[row, FROM_RED + 2])
    end = vec3(rows[row, TO_RED], rows[row, TO_RED + 1], rows[row, TO_RED + 2])
    tall = ti.abs(along[1]) + half + 1.0
    wide = ti.abs(along[0]) + half + 1.0
    left, right = between(x, wide, tile.left, tile.right)
    top, bottom = between(y, ti.min(tall, reach), tile.top, tile.bottom)
    for line in range(top, bottom):
        for column in range(left, right):
            node = tile.origin + line * TILE + column
            away = vec2(column - x, line - y)
            t = away.dot(along) / square
            inside = (t >= -1.0) & (t < 1.0)
            on = ti.min(ti.max(t, -1.0), 1.0)
            distance = (away - along * on).norm()
            covered = _ramp(half + 0.5 - distance)
            here = color[node]
            if (inside | (half > ROUND)) & (covered > 0.0) & (here[3] > FAINT):
                aside = (along[0] * away[1] - along[1] * away[0]) / (half * ti.sqrt(square))
                across = ti.min(ti.abs(aside), 1.0)
                share = 0.5 * on + 0.5
                light = (start * (1.0 - share) + end * share) * (1.15 - 0.75 * across * across)
                _over(node, here, rows[row, DEPTH], light * (covered * alpha), covered * alpha, color, depth)


@ti.func
def _edge(p, q, away):
    """Signed distance of a point to the line from p to q, pixels, positive on its left."""
    line = q - p
    return (line[0] * (away[1] - p[1]) - line[1] * (away[0] - p[0])) / ti.max(line.norm(), 1e-6)


@ti.func
def draw_triangle(row, rows: ti.template(), tile, color: ti.template(), depth: ti.template()):
    """Draw a triangle; outlines are antialiased, and inner edges leave no gaps."""
    x, y = rows[row, X], rows[row, Y]
    a, b = (
        vec2(rows[row, FIRST_X], rows[row, FIRST_Y]),
        vec2(rows[row, SECOND_X], rows[row, SECOND_Y]),
    )
    c = -a - b
    area = (b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]
    turn = 1.0 if area > 0.0 else -1.0
    edges, alpha = ti.cast(rows[row, EDGES], ti.i32), rows[row, OPACITY]
    low, high = ti.min(a[1], b[1], c[1]) - 1.0, ti.max(a[1], b[1], c[1]) + 1.0
    near, far = ti.min(a[0], b[0], c[0]) - 1.0, ti.max(a[0], b[0], c[0]) + 1.0
    left, right = between(x + 0.5 * (near + far), 0.5 * (far - near), tile.left, tile.right)
    top, bottom = between(y + 0.5 * (low + high), 0.5 * (high - low), tile.top, tile.bottom)
    for line in range(top, bottom):
        for column in range(left, right):
            node = tile.origin + line * TILE + column
            away = vec2(column - x, line - y)
            covered = 1.0
            for k in ti.static(range(3)):
                p = a if ti.static(k == 0) else (b if ti.static(k == 1) else c)
                q = b if ti.static(k == 0) else (c if ti.static(k == 1) else a)
                inside = turn * _edge(p, q, away)
                soft = _ramp(inside + 0.5)
                hard = 1.0 if inside > -0.02 else 0.0
                covered = ti.min(covered, soft if (edges >> k) & 1 else hard)
            here = color[node]
            if (covered > 0.0) & (here[3] > FAINT):
                size = ti.max(ti.abs(area), 1e-6) * turn
                wa = _ramp(((b - away)[0] * (c - away)[1] - (b - away)[1] * (c - away)[0]) / size)
                wb = _ramp(((c - away)[0] * (a - away)[1] - (c - away)[1] * (a - away)[0]) / size)
                wc = ti.max(1.0 - wa - wb, 0.0)
                light = vec3(0.0)
                for k in ti.static(range(3)):
                    light[k] = (
                        wa * rows[row, CORNERS + k] + wb * rows[row, CORNERS + 3 + k] + wc * rows[row, CORNERS + 6 + k]
                    )
                _over(node, here, rows[row, DEPTH], light * (covered * alpha), covered * alpha, color, depth)

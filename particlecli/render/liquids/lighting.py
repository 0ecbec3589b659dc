"""Lighting a pixel of an isosurface by where it faces and how thick the liquid behind it is."""

import taichi as ti

from particlecli.render.arrays import vec3, vec4
from particlecli.render.liquids.density import ACROSS, BEND, BLUES, DOWN, GREENS, NEAR, REDS, SHARES, SLOPE, F, solve
from particlecli.render.liquids.material import TEXELS
from particlecli.render.liquids.records import EX, EY, SHARE, X, Y

ROWS = 8
"""Rows of a band."""

COARSE = 8
"""Pixels along each side of a square that has one thickness; between their middles it is interpolated."""

MIDDLE = 0.5 * (COARSE - 1)
"""Where the middle of the first square is, pixels."""

LINES = ROWS // COARSE + 2
"""Lines of squares of a band, with one above it and one below."""

OPAQUE = 1e6
"""Of liquids of such an optical depth the thickness does not matter."""

FACING = 0.998
"""Tables are looked up no further out than this."""


@ti.func
def add_thickness(row, rows: ti.template(), top, squares, worker, thick: ti.template()):
    """Add how much of a blob rays go through, (1 − q)⁴ where q is least; blobs of less than a square are spread."""
    wide, high = ti.max(rows[row, EX], 1.25 * COARSE), ti.max(rows[row, EY], 1.25 * COARSE)
    share = rows[row, SHARE] * rows[row, EX] * rows[row, EY] / (wide * high)
    x, y = (rows[row, X] - MIDDLE) / COARSE + 1.0, (rows[row, Y] - top - MIDDLE) / COARSE + 1.0
    across, down = COARSE / wide, COARSE / high
    left = ti.max(ti.cast(ti.ceil(x - 1.0 / across), ti.i32), 0)
    right = ti.min(ti.cast(ti.floor(x + 1.0 / across), ti.i32) + 1, squares)
    for line in range(
        ti.max(ti.cast(ti.ceil(y - 1.0 / down), ti.i32), 0), ti.min(ti.cast(y + 1.0 / down, ti.i32) + 1, LINES)
    ):
        above = (line - y) * down
        for i in range(left, right):
            beside = (i - x) * across
            rest = ti.max(1.0 - above * above - beside * beside, 0.0)
            twice = rest * rest
            thick[worker, line * squares + i] = thick[worker, line * squares + i] + share * twice * twice


@ti.func
def _thickness(x, below, squares, worker, thick: ti.template()):
    """How many blobs the ray through a pixel goes through; `below` counts lines from the band's top."""
    a, b = (x - MIDDLE) / COARSE + 1.0, (below - MIDDLE) / COARSE + 1.0
    i, j = ti.cast(a, ti.i32), ti.cast(b, ti.i32)
    s, t = a - i, b - j
    place = j * squares + i
    upper = thick[worker, place] * (1.0 - s) + thick[worker, place + 1] * s
    lower = thick[worker, place + squares] * (1.0 - s) + thick[worker, place + squares + 1] * s
    return upper * (1.0 - t) + lower * t


@ti.func
def _texel(table: ti.template(), u, v, column: ti.template()):
    """Four numbers of a table at u, v in −1..1, bilinear."""
    x, y = (u * 0.5 + 0.5) * (TEXELS - 1), (v * 0.5 + 0.5) * (TEXELS - 1)
    i, j = ti.cast(x, ti.i32), ti.cast(y, ti.i32)
    s, t = x - i, y - j
    place = j * TEXELS + i
    result = vec4(0.0)
    for k in ti.static(range(4)):
        upper = table[place, column + k] * (1.0 - s) + table[place + 1, column + k] * s
        lower = table[place + TEXELS, column + k] * (1.0 - s) + table[place + TEXELS + 1, column + k] * s
        result[k] = upper * (1.0 - t) + lower * t
    return result


@ti.func
def light(
    x, y, top, squares, cell, at, worker, cells: ti.template(), thick: ti.template(), table: ti.template(), lens, level,
    opacity_depth, metal, node, lit: ti.template(), shape: ti.template(),
):  # fmt: skip
    """Light a pixel whose ray has come to the surface."""
    density, slope = cells[worker, cell, F][at], cells[worker, cell, SLOPE][at]
    step, over, ratio, _ = solve(density, slope, cells[worker, cell, BEND][at], level)
    depth = cells[worker, cell, NEAR][at] + step
    scale = lens.focal / ti.max(lens.slope * depth + lens.level, lens.near)
    across, up = cells[worker, cell, ACROSS][at], -cells[worker, cell, DOWN][at]
    steepness = ti.max(ti.sqrt(across * across + up * up), 1e-20)
    toward = ti.max(0.125 * slope / scale, 0.0)
    slant = lens.slope / lens.focal
    away, high = (x - lens.center_x) * slant, (lens.center_y - y) * slant
    facing = ti.max(toward - away * across - high * up, 0.0)
    normal = vec3(across + away * toward, up + high * toward, facing)
    normal = normal / ti.max(normal.norm(), 1e-20)
    u, v = normal[0] * FACING, -normal[1] * FACING
    matt, gloss = _texel(table, u, v, 0), _texel(table, u, v, 4)
    opened = 0.0
    if opacity_depth < OPAQUE:
        thin = level * level * level * level
        most = ti.max(_thickness(x, y - top, squares, worker, thick) - thin, 0.0) / (1.0 - thin)
        opened = ti.exp(-opacity_depth * most) * (1.0 - metal)
    shares = vec3(cells[worker, cell, REDS][at], cells[worker, cell, GREENS][at], cells[worker, cell, BLUES][at])
    tint = shares / density
    kept, color = 1.0 - matt[3], vec3(0.0)
    for k in ti.static(range(3)):
        color[k] = tint[k] * (matt[k] * (1.0 - opened) + gloss[3] * opened) * kept
        color[k] += gloss[k] * (1.0 + metal * (tint[k] - 1.0))
    covered = ti.min(over / (8.0 * ratio * steepness), 1.0) * ti.min(cells[worker, cell, SHARES][at] / density, 1.0)
    lit[node] = vec4(color[0], color[1], color[2], 1.0 - opened * kept)
    sideways = ti.sqrt(ti.max(1.0 - normal[2] * normal[2], 0.0)) / steepness
    shape[node] = vec4(ti.max(covered, 0.0), across * sideways, -up * sideways, depth)

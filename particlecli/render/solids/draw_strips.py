"""Drawing a piece of a ribbon or a triangle of a surface into a tile."""

import taichi as ti

from particlecli.render.arrays import vec2, vec3
from particlecli.render.solids.records import (
    CORNERS,
    COVER,
    DEPTH,
    EDGES,
    END_X,
    END_Y,
    EXTENT,
    FIRST_X,
    FIRST_Y,
    FROM_RED,
    HALF,
    OPACITY,
    SECOND_X,
    SECOND_Y,
    TO_RED,
    X,
    Y,
)
from particlecli.render.solids.tiles import between, can_be_seen, cover

THIN = 0.5
"""Ribbons of less than half this width, pixels, are drawn as wide, and hide accordingly less."""

ROUND = 1.5
"""Pieces of ribbons that are wider than twice this have round ends, so that bends have no gaps, pixels."""


@ti.func
def _ramp(t):
    return ti.min(ti.max(t, 0.0), 1.0)


@ti.func
def _three(rows: ti.template(), row, first):
    return vec3(rows[row, first], rows[row, first + 1], rows[row, first + 2])


@ti.func
def draw_piece(body, row, heads: ti.template(), rows: ti.template(), tile, store: ti.template()):
    """Draw a straight piece of a ribbon, bright along its middle as a thread is."""
    x, y, z, reach = heads[body, X], heads[body, Y], heads[body, DEPTH], heads[body, EXTENT]
    along = vec2(rows[row, END_X], rows[row, END_Y])
    half = ti.max(rows[row, HALF], THIN)
    alpha = rows[row, COVER] * ti.min(rows[row, HALF] / THIN, 1.0)
    square = ti.max(along.dot(along), 1e-8)
    start, end = _three(rows, row, FROM_RED), _three(rows, row, TO_RED)
    left, right = between(x, ti.abs(along[0]) + half + 1.0, tile.left, tile.right)
    top, bottom = between(y, ti.min(ti.abs(along[1]) + half + 1.0, reach), tile.top, tile.bottom)
    for line in range(top, bottom):
        for column in range(left, right):
            away = vec2(column - x, line - y)
            t = away.dot(along) / square
            inside = (t >= -1.0) & (t < 1.0)
            on = ti.min(ti.max(t, -1.0), 1.0)
            covered = _ramp(half + 0.5 - (away - along * on).norm())
            if (inside | (half > ROUND)) & (covered > 0.0) & can_be_seen(tile, column, line, store):
                aside = (along[0] * away[1] - along[1] * away[0]) / (half * ti.sqrt(square))
                across = ti.min(ti.abs(aside), 1.0)
                share = 0.5 * on + 0.5
                light = (start * (1.0 - share) + end * share) * (1.15 - 0.75 * across * across)
                cover(tile, column, line, z, light * (covered * alpha), covered * alpha, store)


@ti.func
def _edge(p, q, away):
    """Signed distance of a point to the line from p to q, pixels, positive on its left."""
    line = q - p
    return (line[0] * (away[1] - p[1]) - line[1] * (away[0] - p[0])) / ti.max(line.norm(), 1e-6)


@ti.func
def _cross(u, v):
    return u[0] * v[1] - u[1] * v[0]


@ti.func
def _covered(a, b, c, turn, edges, away):
    """How much of a pixel is in a triangle; inner edges are sharp, so that neighbours leave no gap."""
    covered = 1.0
    for k in ti.static(range(3)):
        p, q = ti.static((a, b, c))[k], ti.static((b, c, a))[k]
        inside = turn * _edge(p, q, away)
        hard = 1.0 if inside > -0.02 else 0.0
        covered = ti.min(covered, _ramp(inside + 0.5) if (edges >> k) & 1 else hard)
    return covered


@ti.func
def draw_triangle(body, row, heads: ti.template(), rows: ti.template(), tile, store: ti.template()):
    """Draw a triangle; outlines are antialiased, and inner edges leave no gaps."""
    x, y, z = heads[body, X], heads[body, Y], heads[body, DEPTH]
    a, b = vec2(rows[row, FIRST_X], rows[row, FIRST_Y]), vec2(rows[row, SECOND_X], rows[row, SECOND_Y])
    c = -a - b
    area = _cross(b - a, c - a)
    turn = 1.0 if area > 0.0 else -1.0
    edges, alpha = ti.cast(rows[row, EDGES], ti.i32), rows[row, OPACITY]
    low, high = ti.min(a[1], b[1], c[1]) - 1.0, ti.max(a[1], b[1], c[1]) + 1.0
    near, far = ti.min(a[0], b[0], c[0]) - 1.0, ti.max(a[0], b[0], c[0]) + 1.0
    left, right = between(x + 0.5 * (near + far), 0.5 * (far - near), tile.left, tile.right)
    top, bottom = between(y + 0.5 * (low + high), 0.5 * (high - low), tile.top, tile.bottom)
    for line in range(top, bottom):
        for column in range(left, right):
            away = vec2(column - x, line - y)
            covered = _covered(a, b, c, turn, edges, away)
            if (covered > 0.0) & can_be_seen(tile, column, line, store):
                size = ti.max(ti.abs(area), 1e-6) * turn
                wa, wb = _ramp(_cross(b - away, c - away) / size), _ramp(_cross(c - away, a - away) / size)
                wc = ti.max(1.0 - wa - wb, 0.0)
                light = vec3(0.0)
                for corner, share in ti.static(((0, wa), (1, wb), (2, wc))):
                    light += _three(rows, row, CORNERS + 3 * corner) * share
                cover(tile, column, line, z, light * (covered * alpha), covered * alpha, store)

"""From particles to blobs: ellipsoids as the camera sees them, drawn out along their velocity."""

import taichi as ti

from particlecli.render.arrays import Row, Rows, Shorts, vec3
from particlecli.render.liquids.records import (
    BLUE,
    DEPTH,
    EX,
    EY,
    EZ,
    GREEN,
    HX,
    HY,
    MXX,
    MXY,
    MYY,
    RED,
    SHARE,
    C,
    X,
    Y,
)
from particlecli.render.project import height_over, on_picture, radiance, table_place, touches_picture, vector
from particlecli.render.shot import lens_in, paint_in
from particlecli.render.solids.sorting import key_of
from particlecli.render.tasks import CHUNK

SMALLEST = 0.8
"""Smaller blobs are drawn with this radius, pixels, and hide accordingly less."""

EDGE = 0.5
"""Blobs are so much wider on the picture, pixels, as edges are antialiased inwards."""

LONGEST = 3.0
"""No blob is drawn out to more times its radius."""

FAINTEST = 1 / 512
"""What is left of less is not drawn."""


@ti.func
def _reach(ratio, along):
    """How far an ellipsoid reaches along an axis, in radii of the ball of its volume; `along` is that of its length."""
    return ti.sqrt((1.0 + (ratio * ratio * ratio - 1.0) * along * along) / ratio)


@ti.func
def _set_shape(i, rows: ti.template(), size, grown, ratio, along, scale):
    """Set how a blob's density falls off, see `records`; `grown` is by what it is thinner than it is drawn."""
    curve, share = ratio / (size * size), 1.0 - 1.0 / (ratio * ratio * ratio)
    c = curve * (1.0 - share * along[2] * along[2]) * scale * scale
    bend = curve * share * along[2] * scale / c
    hx, hy = bend * along[0], bend * along[1]
    values = (
        (EZ, size * _reach(ratio, along[2]) / scale), (C, c), (HX, hx * grown), (HY, hy * grown),
        (MXX, (curve * (1.0 - share * along[0] * along[0]) - c * hx * hx) * grown * grown),
        (MXY, -2.0 * (curve * share * along[0] * along[1] + c * hx * hy) * grown * grown),
        (MYY, (curve * (1.0 - share * along[1] * along[1]) - c * hy * hy) * grown * grown),
    )  # fmt: skip
    for k, value in ti.static(values):
        rows[i, k] = value


@ti.func
def _stretched(speed, stretch, scale, drawn, lens):
    """By what a blob is drawn out, and along which direction on the picture and into it."""
    fast = ti.max(speed.norm(), 1e-20)
    ratio = ti.min(1.0 + 0.5 * stretch * fast * scale / drawn, LONGEST)
    return ratio, vec3(speed.dot(lens.right), -speed.dot(lens.up), speed.dot(lens.forward)) / fast


@ti.kernel
def put_blobs(
    count: ti.i32, positions: Rows, velocities: Rows, quantity: Row, ages: Row, lifetimes: Row, shot: Row,
    planes: Rows, occluders: ti.i32, colors: Rows, rows: Rows, keys: Shorts, source: ti.i32,
    fading: ti.i32, reach: ti.f32, stretch: ti.f32,
):  # fmt: skip
    """Rows of `count` particles, see `records`, and keys of their depths; those that are not seen reach nowhere.

    A blob that moves is drawn out along its velocity v by the factor λ = 1 + stretch |v| / (2 radius), and thinner by
    √λ, so that its volume stays.

    Args:
        shot: the lens, and the paint, whose brightness is 1.
        planes: (normal, height of the camera), of which the first `occluders` hide what is behind them.
        colors: a tint's table, as bright as the group.
        reach: of the density, radii.
        stretch: s.
    """
    ti.loop_config(block_dim=1)
    for chunk in range((count + CHUNK - 1) // CHUNK):
        lens, paint = lens_in(shot), paint_in(shot)
        for i in range(chunk * CHUNK, ti.min(count, chunk * CHUNK + CHUNK)):
            point = vector(positions, i) - lens.origin
            depth = point.dot(lens.forward)
            place, scale, seen = on_picture(point, lens)
            there = seen * radiance(i, ages, lifetimes, paint, fading)
            radius = ti.min(paint.radius * scale + paint.pixels, lens.largest) * ti.sqrt(there)
            for p in range(occluders):
                if height_over(p, planes, point) * scale < -radius:
                    there = 0.0
            drawn = ti.max(radius, SMALLEST)
            size = reach * drawn
            along, ratio = vec3(0.0), 1.0
            if stretch > 0.0:
                ratio, along = _stretched(vector(velocities, i), stretch, scale, drawn, lens)
            grown = drawn / (drawn + EDGE)
            wide = size / grown * _reach(ratio, along[0])
            high = size / grown * _reach(ratio, along[1])
            rows[i, EY] = -1.0
            keys[i] = ti.cast(key_of(depth, lens.near), ti.u16)
            if touches_picture(place, wide, high, lens) & (there > FAINTEST):
                tint = ti.cast(table_place(i, velocities, quantity, ages, lifetimes, paint, source) + 0.5, ti.i32)
                _set_shape(i, rows, size, grown, ratio, along, scale)
                values = (
                    (X, place[0]), (Y, place[1]), (DEPTH, depth), (EX, wide), (EY, high),
                    (SHARE, radius * radius / (drawn * drawn)), (RED, colors[tint, 0]),
                    (GREEN, colors[tint, 1]), (BLUE, colors[tint, 2]),
                )  # fmt: skip
                for k, value in ti.static(values):
                    rows[i, k] = value

"""From particles to billboards: discs that face the camera, each with a picture on it."""

import math

import taichi as ti

from particlecli.render.arrays import Ids, Integers, Row, Rows, Shorts, vec3
from particlecli.render.project import above, on_picture, radiance, table_place, vector
from particlecli.render.shot import lens_in, paint_in
from particlecli.render.solids.draw import SMALLEST
from particlecli.render.solids.records import (
    ALPHA,
    BLUE,
    BLUR,
    COSINE,
    DEPTH,
    EXTENT,
    GREEN,
    HIDDEN,
    LOOK,
    PICTURE,
    RADIUS,
    RED,
    SINE,
    X,
    Y,
)
from particlecli.render.tasks import CHUNK, GRAIN, LANES

FAINTEST = 1 / 512
"""What hides less is not drawn."""

_STEP = 11
"""Bits of a depth's mantissa that do not matter for its key: depths that differ by less than 1/4096 may be alike."""


@ti.func
def key_of(depth, near):
    """Place of a depth in the order from near to far, 0 to HIDDEN − 1."""
    steps = (ti.bit_cast(ti.cast(depth, ti.f32), ti.i32) - ti.bit_cast(ti.cast(near, ti.f32), ti.i32)) >> _STEP
    return ti.min(ti.max(steps, 0), HIDDEN - 1)


@ti.func
def reach(radius, blur, spread):
    """How far from its middle a billboard is drawn, pixels, with its antialiased edge."""
    drawn = ti.max(radius, blur, SMALLEST)
    return spread * (drawn + 0.5) + ti.min(blur, drawn)


@ti.func
def chance(number, salt):
    """A number in 0..1 that belongs to a particle (C. Wellons' hash lowbias32, 2018)."""
    x = ti.cast(number * 2 + salt, ti.u32)
    x = (x ^ (x >> 16)) * ti.u32(0x7FEB352D)
    x = (x ^ (x >> 15)) * ti.u32(0x846CA68B)
    x = x ^ (x >> 16)
    return ti.cast(x >> 8, ti.f32) * (1.0 / 16777216.0)


@ti.func
def _picture(i, ages: ti.template(), lifetimes: ti.template(), ids: ti.template(), pictures, rate, aged):
    """Number of the picture on a sheet: over and over, or by the share of the lifetime, or one for each particle."""
    share = chance(ids[i], 0)
    if rate > 0.0:
        share = share + ages[i] * rate / pictures
        share = share - ti.floor(share)
    elif aged:
        share = ages[i] / lifetimes[i]
    return ti.min(ti.max(ti.floor(share * pictures), 0.0), pictures - 1.0)


@ti.kernel
def put_billboards(
    first: ti.i32, count: ti.i32, positions: Rows, velocities: Rows, quantity: Row, ages: Row, lifetimes: Row,
    ids: Ids, shot: Row, planes: Rows, occluders: ti.i32, colors: Rows, counter: Integers, rows: Rows, keys: Shorts,
    source: ti.i32, fading: ti.i32, aged: ti.i32, look: ti.i32, pictures: ti.f32, rate: ti.f32, spin: ti.f32,
    turned: ti.i32, spread: ti.f32,
):  # fmt: skip
    """Rows of `count` particles, from row `first` on.

    Args:
        shot: the lens, and the paint, whose brightness is how much a particle hides.
        planes: (normal, height of the camera), of which the first `occluders` hide what is behind them.
        colors: a tint's table, as bright as the group.
        look: place in the table of looks.
        pictures: how many its sheet has; `rate`: how many are shown a second, or 0.
        spin: fastest turn either way, radians/s; `turned`: whether each has an angle of its own.
        spread: how far the picture reaches, radii: 1 for a disc, √2 for a square that turns.
    """
    counter[0] = 0
    for lane in range(LANES):
        if lane % GRAIN == 0:
            lens, paint = lens_in(shot), paint_in(shot)
            chunk = ti.atomic_add(counter[0], 1)
            while chunk * CHUNK < count:
                for i in range(chunk * CHUNK, ti.min(count, chunk * CHUNK + CHUNK)):
                    point = vector(positions, i) - lens.origin
                    depth = point.dot(lens.forward)
                    place, scale, seen = on_picture(point, lens)
                    radius = ti.min(paint.radius * scale + paint.pixels, lens.largest)
                    for p in range(occluders):
                        height = planes[p, 3] + vec3(planes[p, 0], planes[p, 1], planes[p, 2]).dot(point)
                        seen = seen * above(height, radius / scale)
                    alpha = seen * radiance(i, ages, lifetimes, paint, fading)
                    blur = ti.abs(lens.blur * (lens.focus - 1.0 / ti.max(depth, lens.near)))
                    extent = reach(radius, blur, spread)
                    inside = (
                        (ti.abs(place[0] - lens.center_x) < lens.center_x + extent)
                        & (ti.abs(place[1] - lens.center_y) < lens.center_y + extent)
                        & (alpha > FAINTEST)
                    )
                    row = first + i
                    keys[row] = ti.cast(HIDDEN, ti.u16)
                    rows[row, EXTENT] = 0.0
                    if inside:
                        keys[row] = ti.cast(key_of(depth, lens.near), ti.u16)
                        tint = ti.cast(
                            table_place(i, velocities, quantity, ages, lifetimes, paint, source) + 0.5, ti.i32
                        )
                        angle = 0.0
                        if turned:
                            angle = 2.0 * math.pi * chance(ids[i], 1)
                            if spin > 0.0:
                                angle = angle + (2.0 * chance(ids[i], 2) - 1.0) * spin * ages[i]
                        values = (
                            (X, place[0]), (Y, place[1]), (DEPTH, depth), (LOOK, look), (EXTENT, extent),
                            (RADIUS, radius), (COSINE, ti.cos(angle)), (SINE, ti.sin(angle)),
                            (PICTURE, _picture(i, ages, lifetimes, ids, pictures, rate, aged)), (ALPHA, alpha),
                            (RED, colors[tint, 0]), (GREEN, colors[tint, 1]), (BLUE, colors[tint, 2]), (BLUR, blur),
                        )  # fmt: skip
                        for k, value in ti.static(values):
                            rows[row, k] = value
                chunk = ti.atomic_add(counter[0], 1)

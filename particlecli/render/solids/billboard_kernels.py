"""From particles to billboards: discs that face the camera, each with a picture on it."""

import math

import taichi as ti

from particlecli.render.arrays import Ids, Row, Rows, vec3
from particlecli.render.project import on_picture, radiance, seen_over_planes, table_place, touches_picture, vector
from particlecli.render.shot import lens_in, paint_in
from particlecli.render.solids.draw_billboards import drawn_as
from particlecli.render.solids.records import (
    ALPHA,
    BLUE,
    BLUR,
    COSINE,
    DEPTH,
    EXTENT,
    GREEN,
    HIDES,
    LARGE,
    LIGHT,
    LOOK,
    PICTURE,
    RADIUS,
    RED,
    ROW,
    SINE,
    X,
    Y,
)
from particlecli.render.tasks import CHUNK

FAINTEST = 1 / 512
"""What hides less is not drawn."""


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


@ti.func
def _turn(id_, age, spin):
    """Angle of a particle, radians."""
    angle = 2.0 * math.pi * chance(id_, 1)
    if spin > 0.0:
        angle = angle + (2.0 * chance(id_, 2) - 1.0) * spin * age
    return angle


@ti.func
def _set_speck(body, heads: ti.template(), means: ti.template(), picture, tint: ti.template(), alpha, hides):
    """Set the light of a particle that is so small that its picture has one colour."""
    for k in ti.static(range(3)):
        heads[body, LIGHT + k] = (means[picture, k] * tint[k] + means[picture, 4 + k]) * alpha
    heads[body, HIDES] = ti.min(means[picture, 3] * alpha, 1.0) * hides


@ti.func
def _set_row(
    body, heads: ti.template(), rows: ti.template(), look, radius, angle, picture, alpha, tint: ti.template(), blur
):  # fmt: skip
    """Set what is drawn of a larger particle; as most are not turned, sine and cosine are not always computed."""
    heads[body, LOOK], heads[body, HIDES], heads[body, ROW] = look, LARGE, ti.bit_cast(body, ti.f32)
    cosine, sine = 1.0, 0.0
    if angle != 0.0:
        cosine, sine = ti.cos(angle), ti.sin(angle)
    values = (
        (RADIUS, radius), (COSINE, cosine), (SINE, sine), (PICTURE, picture), (ALPHA, alpha), (RED, tint[0]),
        (GREEN, tint[1]), (BLUE, tint[2]), (BLUR, blur),
    )  # fmt: skip
    for k, value in ti.static(values):
        rows[body, k] = value


@ti.kernel
def put_billboards(
    first: ti.i32, count: ti.i32, positions: Rows, velocities: Rows, quantity: Row, ages: Row, lifetimes: Row,
    ids: Ids, shot: Row, planes: Rows, occluders: ti.i32, colors: Rows, heads: Rows, rows: Rows,
    source: ti.i32, fading: ti.i32, aged: ti.i32, look: ti.i32, pictures: ti.f32, rate: ti.f32, spin: ti.f32,
    turned: ti.i32, spread: ti.f32, small: ti.f32, means: Rows, hides: ti.f32,
):  # fmt: skip
    """Heads and rows of `count` particles, from the `first` on.

    Args:
        shot: the lens, and the paint, whose brightness is how much a particle hides.
        planes: (normal, height of the camera), of which the first `occluders` hide what is behind them.
        colors: a tint's table, as bright as the group.
        look: place in the table of looks.
        pictures: how many its sheet has; `rate`: how many are shown a second, or 0.
        spin: fastest turn either way, radians/s; `turned`: whether each has an angle of its own.
        spread: how far the picture reaches, radii: 1 for a disc, √2 for a square that turns.
        small: those of a smaller radius, pixels, are specks.
        means: shape (pictures, 8): of a disc of a picture's mean colour the light that takes the tint (3), how much it
            hides, and the light that does not (3).
        hides: share of what pictures hide.
    """
    ti.loop_config(block_dim=1)
    for chunk in range((count + CHUNK - 1) // CHUNK):
        lens, paint = lens_in(shot), paint_in(shot)
        for i in range(chunk * CHUNK, ti.min(count, chunk * CHUNK + CHUNK)):
            point = vector(positions, i) - lens.origin
            depth = point.dot(lens.forward)
            place, scale, seen = on_picture(point, lens)
            sharp = ti.min(paint.radius * scale + paint.pixels, lens.largest)
            seen = seen_over_planes(seen, point, sharp / scale, planes, occluders)
            whole = seen * radiance(i, ages, lifetimes, paint, fading)
            blur = ti.abs(lens.blur * (lens.focus - 1.0 / ti.max(depth, lens.near)))
            radius, alpha = drawn_as(sharp, blur, whole)
            extent = radius + 0.5
            if radius >= small:
                extent = spread * extent + ti.min(blur, radius)
            body = first + i
            heads[body, EXTENT] = 0.0
            if touches_picture(place, extent, extent, lens) & (whole > FAINTEST):
                at = ti.cast(table_place(i, velocities, quantity, ages, lifetimes, paint, source) + 0.5, ti.i32)
                tint = vec3(colors[at, 0], colors[at, 1], colors[at, 2])
                picture = _picture(i, ages, lifetimes, ids, pictures, rate, aged)
                for k, value in ti.static(((X, place[0]), (Y, place[1]), (DEPTH, depth), (EXTENT, extent))):
                    heads[body, k] = value
                if radius < small:
                    _set_speck(body, heads, means, ti.cast(picture, ti.i32), tint, alpha, hides)
                else:
                    angle = 0.0
                    if turned:
                        angle = _turn(ids[i], ages[i if spin > 0.0 else 0], spin)
                    _set_row(body, heads, rows, look, sharp, angle, picture, whole, tint, blur)

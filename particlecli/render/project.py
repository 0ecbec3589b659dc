"""From particles to sprites: where each lands in the picture, how large, how bright, in which colour.

A sprite is light spread over a round spot: its place (pixels), its radius, its energy (the sum of all pixel
values it adds, for a tint of 1) and its place in the tint's table; smeared sprites also have a tail, the
vector back to where they were when the shutter opened. Particles that are not seen get energy 0.
"""

import math

import taichi as ti

from particlecli.render.arrays import Integers, Row, Rows, vec2, vec3
from particlecli.render.particles import GIVEN, LIFE_SHARE, SPEED
from particlecli.render.shot import lens_in, paint_in
from particlecli.render.sprites import ENERGY, PACK, RADIUS, SEEN, TAIL_X, TAIL_Y, TINT, X, Y
from particlecli.render.tasks import CHUNK, GRAIN, LANES


@ti.func
def smooth(t):
    """0 up to t = 0, 1 from t = 1 on, without a kink."""
    s = ti.min(ti.max(t, 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s)


@ti.func
def vector(rows: ti.template(), i):
    """A vector of three rows."""
    return vec3(rows[0, i], rows[1, i], rows[2, i])


@ti.func
def table_place(
    i, velocities: ti.template(), quantity: ti.template(), ages: ti.template(), lifetimes: ti.template(),
    paint, source,
):  # fmt: skip
    """Place of a particle in the tint's table, between the first and the last."""
    value = paint.low
    if source == GIVEN:
        value = quantity[i]
    elif source == LIFE_SHARE:
        value = ages[i] / lifetimes[i]
    elif source == SPEED:
        value = vector(velocities, i).norm()
    return ti.min(ti.max((value - paint.low) * paint.scale, 0.0), paint.last)


@ti.func
def radiance(i, ages: ti.template(), lifetimes: ti.template(), paint, fading):
    """Light of each pixel that a particle covers, for a tint of 1."""
    light = paint.brightness
    if fading:
        share = ages[i] / lifetimes[i]
        rise = smooth(share * paint.rise + paint.rise_start)
        light = light * rise * smooth((1.0 - share) * paint.fall + paint.fall_end)
    return light


@ti.func
def above(height, radius):
    """Share of a particle that is seen over a plane: all while its middle is above, none a diameter below."""
    return smooth(1.0 + height / (2.0 * radius))


@ti.func
def scale_at(depth, lens):
    """Pixels a metre at a depth."""
    return lens.focal / ti.max(lens.slope * depth + lens.level, lens.near)


@ti.func
def blurred(radius, depth, lens):
    """Radius in pixels of a particle that the lens blurs: variances add up, R² = r² + c².

    The radius of the blur of a thin lens is c = ½ aperture · focal · |1/focus − 1/depth|.
    """
    blur = lens.blur * (lens.focus - 1.0 / ti.max(depth, lens.near))
    return ti.sqrt(radius * radius + blur * blur)


@ti.func
def on_picture(point, lens):
    """Place in pixels, pixels a metre there, and how much of the light comes past the near limit."""
    depth = point.dot(lens.forward)
    scale = scale_at(depth, lens)
    across, up = point.dot(lens.right) * scale, point.dot(lens.up) * scale
    return vec2(lens.center_x + across, lens.center_y - up), scale, smooth(depth / lens.near - 1.0)


@ti.func
def exposed(i, ages: ti.template(), paint, aged):
    """For how long a particle was seen while the shutter was open, and the share of the exposure that is."""
    seconds, share = paint.exposure, 1.0
    if aged:
        seconds = ti.min(seconds, ages[i])
        share = seconds / paint.exposure
    return seconds, share


@ti.func
def start_of_path(point, velocity, seconds, lens):
    """Where a particle was `seconds` ago, in pixels; if behind the camera, where it passed the near limit."""
    before = point - velocity * seconds
    depth, depth_before = point.dot(lens.forward), before.dot(lens.forward)
    if depth_before < lens.near and depth > lens.near:
        before = point + (before - point) * ((depth - lens.near) / (depth - depth_before))
    place, _, _ = on_picture(before, lens)
    return place


@ti.func
def put(sprites: ti.template(), which, k, place, radius, energy, tint):
    """Set a sprite of a set, but for its tail."""
    b, lane = k // PACK, k % PACK
    sprites[which, X, b][lane] = place[0]
    sprites[which, Y, b][lane] = place[1]
    sprites[which, RADIUS, b][lane] = radius
    sprites[which, ENERGY, b][lane] = energy
    sprites[which, TINT, b][lane] = tint


@ti.func
def put_tail(sprites: ti.template(), which, k, tail):
    """Set a sprite's tail."""
    sprites[which, TAIL_X, k // PACK][k % PACK] = tail[0]
    sprites[which, TAIL_Y, k // PACK][k % PACK] = tail[1]


@ti.kernel
def project(
    first: ti.i32, count: ti.i32, positions: Rows, velocities: Rows, quantity: Row, ages: Row, lifetimes: Row,
    shot: Row, planes: Rows, counter: Integers, sprites: ti.template(),
    source: ti.i32, fading: ti.i32, aged: ti.i32, smeared: ti.template(), occluders: ti.template(),
):  # fmt: skip
    """Sprites of `count` particles from the `first` on, as the camera sees them; `shot` has its lens and their paint.

    Energy is π radius² × radiance. Particles behind one of the `occluders` planes (normal, height of the
    camera above it) are hidden.
    """
    counter[0] = 0
    for lane in range(LANES):
        if lane % GRAIN == 0:
            lens, paint = lens_in(shot), paint_in(shot)
            chunk = ti.atomic_add(counter[0], 1)
            while chunk * CHUNK < count:
                for k in range(chunk * CHUNK, ti.min(count, chunk * CHUNK + CHUNK)):
                    i = first + k
                    point = vector(positions, i) - lens.origin
                    place, scale, light = on_picture(point, lens)
                    radius = ti.min(paint.radius * scale + paint.pixels, lens.largest)
                    for p in ti.static(range(occluders)):
                        height = planes[p, 3] + vec3(planes[p, 0], planes[p, 1], planes[p, 2]).dot(point)
                        light = light * above(height, radius / scale)
                    light = light * radiance(i, ages, lifetimes, paint, fading)
                    if ti.static(smeared):
                        seconds, share = exposed(i, ages, paint, aged)
                        light = light * share
                        put_tail(sprites, SEEN, k, start_of_path(point, vector(velocities, i), seconds, lens) - place)
                    tint = table_place(i, velocities, quantity, ages, lifetimes, paint, source)
                    wide = ti.min(blurred(radius, point.dot(lens.forward), lens), lens.largest)
                    put(sprites, SEEN, k, place, wide, light * (math.pi * radius * radius), tint)
                chunk = ti.atomic_add(counter[0], 1)

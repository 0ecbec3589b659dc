"""From particles to sprites that a plane shows: their mirror images, and the light they throw on it."""

import math

import taichi as ti

from particlecli.render.arrays import Ids, Row, Rows, vec2
from particlecli.render.project import (
    above,
    blurred,
    exposed,
    on_picture,
    put,
    put_tail,
    radiance,
    scale_at,
    start_of_path,
    table_place,
    vector,
)
from particlecli.render.shot import MIRROR, lens_in, mirror_in, paint_in
from particlecli.render.sprites import ENERGY, PACK, POOLED, SEEN
from particlecli.render.tasks import CHUNK

FACING = 0.2
"""Share of the strength that a plane mirrors straight back; at grazing angles it is all of it."""

POOL_WIDTH = 0.6
"""Deviation of the light a point throws on a plane, in heights above it; the halo adds the wide flanks."""

POOL_BLUR = 0.7
"""Variance that this light has at least, cells²."""


@ti.func
def _mirrored(
    i, k, point, velocities: ti.template(), ages: ti.template(), lens, paint, mirror, light, tint, resolution,
    sprites: ti.template(), aged, smeared,
):  # fmt: skip
    """Set the sprite of a particle's mirror image in a rough plane; `resolution` scales the picture.

    Light that leaves a plane at grazing angles is mirrored more (after C. Schlick, 1994); it spreads by
    the roughness times the share of the way that lies behind the mirror, height / (height + camera's).
    """
    height = mirror.height + mirror.normal.dot(point)
    image = point - 2.0 * height * mirror.normal
    place, scale, seen = on_picture(image, lens)
    x, y = place[0], place[1]
    radius = ti.min(paint.radius * scale + paint.pixels, lens.largest)
    way = height + mirror.height
    grazing = 1.0 - way / image.norm()
    seen = seen * (FACING + (1.0 - FACING) * grazing * grazing * grazing)
    seen = seen * mirror.strength * above(height, radius / scale) * light
    if smeared:
        seconds, share = exposed(i, ages, paint, aged)
        seen = seen * share
        velocity = vector(velocities, i)
        velocity = velocity - 2.0 * mirror.normal.dot(velocity) * mirror.normal
        start = start_of_path(image, velocity, seconds, lens)
        put_tail(sprites, SEEN, k, vec2(start[0] - x, start[1] - y) * resolution)
    spread = lens.focal * mirror.roughness * ti.max(height, 0.0) / ti.max(way, 1e-6)
    sharp = ti.sqrt(radius * radius + 4.0 * spread * spread)
    wide = ti.min(blurred(sharp, image.dot(lens.forward), lens), lens.largest) * resolution
    put(sprites, SEEN, k, vec2(x, y) * resolution, wide, seen * math.pi * (radius * resolution) ** 2, tint)


@ti.func
def _pooled(k, point, lens, paint, mirror, light, tint, sprites: ti.template()):
    """Set the sprite of the light that a particle throws on a plane, on the plane's own grid.

    A ball of radius r and radiance 1 sends 2π · πr² into the half space towards the plane; the values are
    irradiance: that light over the area of a cell.
    """
    height = mirror.height + mirror.normal.dot(point)
    scale = scale_at(point.dot(lens.forward), lens)
    radius = paint.radius + paint.pixels / scale
    flux = 2.0 * math.pi * math.pi * (radius * mirror.cells) ** 2 * light * above(height, radius)
    offset = point - mirror.origin
    width = POOL_WIDTH * ti.max(height, 0.0) * mirror.cells
    size = 2.0 * ti.sqrt(width * width + POOL_BLUR)
    put(sprites, POOLED, k, vec2(offset.dot(mirror.along), offset.dot(mirror.across)), size, flux, tint)


@ti.kernel
def reflect(
    first: ti.i32, count: ti.i32, positions: Rows, velocities: Rows, quantity: Row, ages: Row, lifetimes: Row,
    ids: Ids, shot: Row, sprites: ti.template(),
    mirrored_one_in: ti.i32, pooled_one_in: ti.i32, resolution: ti.f32,
    at: ti.i32, source: ti.i32, fading: ti.i32, aged: ti.i32, smeared: ti.i32, alone: ti.template(),
):  # fmt: skip
    """Sprites of the particles' mirror images in a plane, and of the light that they throw on it.

    Of many particles only one in `…_one_in` is taken, chosen by its id, and stands for the others. `shot` has the
    lens, the paint and the mirror. Sprites come to the places from `at` on of both sets; one thread does it `alone`.
    """
    if ti.static(alone):
        ti.loop_config(serialize=True)
    else:
        ti.loop_config(block_dim=1)
    for chunk in range((count + CHUNK - 1) // CHUNK):
        lens, paint, mirror = lens_in(shot), paint_in(shot), mirror_in(shot, MIRROR)
        for k in range(chunk * CHUNK, ti.min(count, chunk * CHUNK + CHUNK)):
            i, s = first + k, at + k
            sprites[SEEN, ENERGY, s // PACK][s % PACK] = 0.0
            sprites[POOLED, ENERGY, s // PACK][s % PACK] = 0.0
            in_mirror, in_pool = ids[i] % mirrored_one_in == 0, ids[i] % pooled_one_in == 0
            if in_mirror or in_pool:
                point = vector(positions, i) - lens.origin
                light = radiance(i, ages, lifetimes, paint, fading)
                tint = table_place(i, velocities, quantity, ages, lifetimes, paint, source)
                if in_mirror:
                    _mirrored(
                        i, s, point, velocities, ages, lens, paint, mirror, light * mirrored_one_in, tint,
                        resolution, sprites, aged, smeared,
                    )  # fmt: skip
                if in_pool:
                    _pooled(s, point, lens, paint, mirror, light * pooled_one_in, tint, sprites)

"""Shadows on planes: how much light particles take, gathered on a plane's grid and seen on the picture."""

import math

import taichi as ti

from particlecli.render.arrays import Ids, Row, Rows, vec2, vec3
from particlecli.render.project import above, put, radiance, scale_at, vector
from particlecli.render.shot import MIRROR, lens_in, mirror_in, paint_in
from particlecli.render.sprites import POOLED
from particlecli.render.tasks import CHUNK

PENUMBRA = 0.12
"""Width that the edge of a shadow gains for each metre of way, m: the lamp is not a point."""

FINEST = 2.0
"""Least radius of a shadow on the grid, cells."""


@ti.kernel
def cast(
    first: ti.i32, count: ti.i32, positions: Rows, ages: Row, lifetimes: Row, ids: Ids, shot: Row, sun: vec3,
    sprites: ti.template(), at: ti.i32, one_in: ti.i32, fading: ti.i32,
):  # fmt: skip
    """Sprites of the shadows of `count` particles on a plane's grid; their light is an optical depth.

    Args:
        shot: lens, paint, whose brightness is the depth in the middle of a shadow, and the plane.
        sun: where the light comes from, of length 1.
        at: place of the first sprite in the set POOLED.
        one_in: of many particles one in so many is taken, chosen by its id, and stands for the others.
    """
    ti.loop_config(block_dim=1)
    for chunk in range((count + CHUNK - 1) // CHUNK):
        lens, paint, plane = lens_in(shot), paint_in(shot), mirror_in(shot, MIRROR)
        falling = plane.normal.dot(sun)
        for k in range(chunk * CHUNK, ti.min(count, chunk * CHUNK + CHUNK)):
            i = first + k
            point = vector(positions, i) - lens.origin
            height = plane.height + plane.normal.dot(point)
            radius = paint.radius + paint.pixels / scale_at(point.dot(lens.forward), lens)
            way = ti.max(height, 0.0) / ti.max(falling, 1e-3)
            offset = point - sun * way - plane.origin
            blur = PENUMBRA * way
            wide = ti.sqrt((radius * radius + blur * blur) * plane.cells**2 + FINEST * FINEST)
            depth = radiance(i, ages, lifetimes, paint, fading) * above(height, radius) * one_in
            if (ids[i] % one_in != 0) | (falling <= 0.0):
                depth = 0.0
            energy = depth * math.pi * (radius * plane.cells) ** 2
            place = vec2(offset.dot(plane.along), offset.dot(plane.across))
            put(sprites, POOLED, at + k, place, wide, energy, 0.0)


@ti.kernel
def shade(
    light: ti.template(), origin: ti.i32, pitch: ti.i32, cells: ti.f32, plane_row: Row, rays: Rows,
    covered: Rows, cover: Rows, width: ti.i32, height: ti.i32,
):  # fmt: skip
    """Take from `cover` what lies in shadow of a plane that covers `covered`; the optical depth is in `light`."""
    ti.loop_config(block_dim=1)
    for y in range(height):
        plane = mirror_in(plane_row, 0)
        for x in range(width):
            start, ray = vec3(0.0), vec3(0.0)
            for k in ti.static(range(3)):
                start[k] = rays[0, k] + x * rays[1, k] + y * rays[2, k]
                ray[k] = rays[3, k] + x * rays[4, k] + y * rays[5, k]
            sinking = -plane.normal.dot(ray)
            if (covered[y, x] > 0.0) & (sinking > 1e-6):
                way = (plane.height + plane.normal.dot(start)) / sinking
                offset = start + ray * way - plane.origin
                a, b = offset.dot(plane.along), offset.dot(plane.across)
                if (a >= 0.0) & (b >= 0.0) & (a < cells - 1.0) & (b < cells - 1.0):
                    i, j = ti.cast(a, ti.i32), ti.cast(b, ti.i32)
                    s, t = a - i, b - j
                    node = origin + j * pitch + i
                    upper = light[node][0] * (1.0 - s) + light[node + 1][0] * s
                    lower = light[node + pitch][0] * (1.0 - s) + light[node + pitch + 1][0] * s
                    depth = upper * (1.0 - t) + lower * t
                    cover[y, x] = cover[y, x] + covered[y, x] * (ti.exp(-depth) - 1.0)

"""What is seen on a ground plane: the light it throws back, and laying all of it under the picture."""

import math

import taichi as ti

from particlecli.render.arrays import Integers, Row, Rows, vec3, vec4
from particlecli.render.shot import mirror_in
from particlecli.render.spread import REACH
from particlecli.render.tasks import WORKERS

EDGE = 0.15
"""Part of the grid, at its edge, over which the pool fades."""


@ti.func
def _at(light: ti.template(), origin, pitch, x, y):
    """Light of a grid between its nodes, bilinear; `origin` is where its first row and column meet."""
    i, j = ti.cast(ti.floor(x), ti.i32), ti.cast(ti.floor(y), ti.i32)
    s, t = x - i, y - j
    node = origin + j * pitch + i
    upper = light[node] * (1.0 - s) + light[node + 1] * s
    return upper * (1.0 - t) + (light[node + pitch] * (1.0 - s) + light[node + pitch + 1] * s) * t


@ti.func
def _vector(rows: ti.template(), k):
    return vec3(rows[k, 0], rows[k, 1], rows[k, 2])


@ti.func
def _inside(place, cells):
    """1 in the middle of the grid, falling to 0 at its edges."""
    t = ti.min(ti.max(ti.min(place, cells - 1.0 - place) / (EDGE * cells), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


@ti.kernel
def add_pool(
    light: ti.template(), origin: ti.i32, pitch: ti.i32, width: ti.i32, height: ti.i32,
    pool_origin: ti.i32, pool_pitch: ti.i32, cells: ti.f32, mirror_row: Row, albedo: vec3, rays: Rows,
):  # fmt: skip
    """Add what a matt plane throws back of its irradiance, albedo / π × E, to a picture of it.

    Args:
        light: of the picture, from `origin` on, and from `pool_origin` on the irradiance on the plane's grid of
            `cells` × `cells`.
        rays: see `View.rays`.
    """
    ti.loop_config(block_dim=1)
    for row in range(height + 2 * REACH):
        mirror = mirror_in(mirror_row, 0)
        y = row - REACH
        for x in range(-REACH, width + REACH):
            start = _vector(rays, 0) + x * _vector(rays, 1) + y * _vector(rays, 2)
            ray = _vector(rays, 3) + x * _vector(rays, 4) + y * _vector(rays, 5)
            sinking = -mirror.normal.dot(ray)
            if sinking > 1e-6:
                way = (mirror.height + mirror.normal.dot(start)) / sinking
                offset = start + ray * way - mirror.origin
                a, b = offset.dot(mirror.along), offset.dot(mirror.across)
                near = _inside(a, cells) * _inside(b, cells)
                if near > 0.0:
                    back = _at(light, pool_origin, pool_pitch, a, b) * (near / math.pi)
                    node = origin + y * pitch + x
                    light[node] = light[node] + back * vec4(albedo[0], albedo[1], albedo[2], 0.0)


@ti.kernel
def lay_ground(
    light: ti.template(), rows: ti.template(), counter: Integers,
    origin: ti.i32, pitch: ti.i32, first: ti.i32, end: ti.i32, width: ti.i32,
    seen: ti.i32, seen_pitch: ti.i32, seen_width: ti.i32, step: ti.i32, cover: Rows,
):  # fmt: skip
    """Add the light on a plane, from node `seen` on and with `step` pixels to a node, in rows `first` to `end`."""
    counter[0] = first
    ti.loop_config(block_dim=1)
    for worker in range(WORKERS):
        y = ti.atomic_add(counter[0], 1)
        while y < end:
            j = y // step
            t = (y - j * step) * (1.0 / step)
            upper, node = seen + j * seen_pitch, origin + y * pitch
            for i in range(seen_width + 1):
                rows[worker, i] = light[upper + i] * (1.0 - t) + light[upper + seen_pitch + i] * t
            for i in range((width + step - 1) // step):
                left, right = rows[worker, i], rows[worker, i + 1]
                for x in range(i * step, ti.min((i + 1) * step, width)):
                    s = (x - i * step) * (1.0 / step)
                    back = (left * (1.0 - s) + right * s) * cover[y, x]
                    light[node + x] = light[node + x] + back * vec4(1.0, 1.0, 1.0, 0.0)
            y = ti.atomic_add(counter[0], 1)

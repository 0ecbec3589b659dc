"""Laying a layer of bodies into a picture, and hiding lights behind it."""

import taichi as ti

from particlecli.render.arrays import Rows, vec4
from particlecli.render.sprites import ENERGY, PACK, SEEN, X, Y
from particlecli.render.tasks import CHUNK


@ti.kernel
def lay(
    color: ti.template(), light: ti.template(), origin: ti.i32, pitch: ti.i32, width: ti.i32,
    height: ti.i32, exposed_open: Rows, cover: Rows,
):  # fmt: skip
    """Lay a layer over the light of a picture, and over how much of the sky and of the ground is seen in it."""
    ti.loop_config(block_dim=1)
    for y in range(height):
        for x in range(width):
            body = color[y * width + x]
            node = origin + y * pitch + x
            light[node] = light[node] * body[3] + vec4(body[0], body[1], body[2], 0.0)
            exposed_open[y, x] = exposed_open[y, x] * body[3]
            cover[y, x] = cover[y, x] * body[3]


@ti.kernel
def hide(
    first: ti.i32, count: ti.i32, positions: Rows, origin_x: ti.f32, origin_y: ti.f32, origin_z: ti.f32,
    forward_x: ti.f32, forward_y: ti.f32, forward_z: ti.f32, width: ti.i32, height: ti.i32,
    color: ti.template(), depth: ti.template(), sprites: ti.template(), place: ti.i32,
):  # fmt: skip
    """Dim sprites of light, from a place on, that are behind bodies."""
    ti.loop_config(block_dim=1)
    for chunk in range((count + CHUNK - 1) // CHUNK):
        for k in range(chunk * CHUNK, ti.min(count, chunk * CHUNK + CHUNK)):
            i = first + k
            away = (
                (positions[0, i] - origin_x) * forward_x
                + (positions[1, i] - origin_y) * forward_y
                + (positions[2, i] - origin_z) * forward_z
            )
            b, at = (place + k) // PACK, (place + k) % PACK
            x = ti.min(ti.max(sprites[SEEN, X, b][at] + 0.5, 0.0), width - 1.0)
            y = ti.min(ti.max(sprites[SEEN, Y, b][at] + 0.5, 0.0), height - 1.0)
            node = ti.cast(y, ti.i32) * width + ti.cast(x, ti.i32)
            if away > depth[node]:
                sprites[SEEN, ENERGY, b][at] = sprites[SEEN, ENERGY, b][at] * color[node][3]

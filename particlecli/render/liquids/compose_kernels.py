"""Laying an isosurface into a layer of bodies, with what is seen through it."""

import taichi as ti

from particlecli.render.arrays import Rows, vec3, vec4


@ti.func
def _edge(node, x, y, width, height, lit: ti.template(), shape: ti.template()):
    """Light, and how much is covered, of a pixel; at an edge before more liquid both are mixed."""
    here = shape[node]
    light, covered = lit[node], here[0]
    if covered < 1.0:
        length = ti.max(ti.sqrt(here[1] * here[1] + here[2] * here[2]), 1e-6)
        i = ti.min(ti.max(x + ti.cast(ti.round(1.5 * here[1] / length), ti.i32), 0), width - 1)
        j = ti.min(ti.max(y + ti.cast(ti.round(1.5 * here[2] / length), ti.i32), 0), height - 1)
        there = shape[j * width + i]
        if (there[0] > covered) & (there[3] > here[3]):
            light = light * covered + lit[j * width + i] * (1.0 - covered)
            covered = covered + there[0] * (1.0 - covered)
    return light, covered


@ti.func
def _over_planes(x, y, z, planes: ti.template(), hiding, rays: ti.template()):
    """Share of a pixel whose surface, at depth z, is not below a plane."""
    point, across = vec3(0.0), vec3(0.0)
    for k in ti.static(range(3)):
        point[k] = rays[0, k] + x * rays[1, k] + y * rays[2, k]
        point[k] += z * (rays[3, k] + x * rays[4, k] + y * rays[5, k])
        across[k] = rays[1, k] + z * rays[4, k]
    share = 1.0
    for p in range(hiding):
        height = planes[p, 3] + planes[p, 0] * point[0] + planes[p, 1] * point[1] + planes[p, 2] * point[2]
        share = ti.min(share, ti.min(ti.max(height / across.norm() + 1.0, 0.0), 1.0))
    return share


@ti.kernel
def compose(
    lit: ti.template(), shape: ti.template(), held: ti.template(), opened: ti.template(), color: ti.template(),
    depth: ti.template(), sky: Rows, cover: Rows, width: ti.i32, height: ti.i32, bending: ti.f32, planes: Rows,
    hiding: ti.i32, rays: Rows,
):  # fmt: skip
    """Lay a surface into a layer of bodies, before or behind what is there.

    Args:
        lit, shape, held, opened: see `Room`.
        color, depth: see `solids.layer.Layer`.
        sky, cover: shape (height, width or more), how much is seen of sky and ground; they shift with what is
            refracted.
        bending: how far what is behind shifts where the surface is seen from the side, pixels; 0: it does not.
        planes, hiding: (normal, height of the camera), of which the first `hiding` hide what is below them.
        rays: see `View.rays`.
    """
    for y in range(height if bending > 0.0 else 0):
        for x in range(width):
            held[y * width + x] = color[y * width + x]
            opened[y * width + x] = vec3(sky[y, x], cover[y, x], depth[y * width + x])
    ti.loop_config(block_dim=1)
    for y in range(height):
        for x in range(width):
            node = y * width + x
            here = shape[node]
            if here[0] > 0.0:
                z = here[3]
                light, covered = _edge(node, x, y, width, height, lit, shape)
                covered = covered * _over_planes(x, y, z, planes, hiding, rays)
                old, before = color[node], depth[node]
                hides = covered * light[3]
                if before < z:
                    color[node] = old + vec4(light[0], light[1], light[2], -light[3]) * (covered * old[3])
                else:
                    if bending > 0.0:
                        i = ti.min(ti.max(x - ti.cast(ti.round(bending * here[1]), ti.i32), 0), width - 1)
                        j = ti.min(ti.max(y - ti.cast(ti.round(bending * here[2]), ti.i32), 0), height - 1)
                        other = j * width + i
                        if opened[other][2] > z:
                            old = old + (held[other] - old) * covered
                            seen = opened[node] + (opened[other] - opened[node]) * covered
                            sky[y, x] = seen[0]
                            cover[y, x] = seen[1]
                    color[node] = vec4(light[0], light[1], light[2], 0.0) * covered + old * (1.0 - hides)
                if (old[3] >= 0.5) & (old[3] * (1.0 - hides) < 0.5):
                    depth[node] = ti.min(before, z)

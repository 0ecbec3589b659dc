"""The kernel that lists what is near packs of particles."""

import taichi as ti

from particlecli.dynamics.coupled.neighbor_grid import INDEX3, INTEGERS, VECTOR3, number, picked, place
from particlecli.dynamics.coupled.sharing import BLOCK

BEYOND = 1e30
"""A squared distance, m², beyond every cutoff."""


@ti.func
def targets(rows: ti.template(), b, count):
    """Packs x, y, z of the particles of a pack; behind the last particle its lanes repeat it."""
    x = ti.Vector([rows.at[ti.min(b * rows.width + k, count - 1)][0] for k in ti.static(range(rows.width))])
    y = ti.Vector([rows.at[ti.min(b * rows.width + k, count - 1)][1] for k in ti.static(range(rows.width))])
    z = ti.Vector([rows.at[ti.min(b * rows.width + k, count - 1)][2] for k in ti.static(range(rows.width))])
    return [x, y, z]


@ti.func
def span(corner, k: ti.template(), low, inverse, counts, axes):
    """The bin along the k-th axis of the grid of a corner."""
    return place(ti.cast(picked(corner, axes[k]), ti.f64), low[k], inverse[k], counts[k])


@ti.func
def gap2(i, k: ti.template(), low, sides, counts, axes, nearest, farthest):
    """The square of the distance from a box to the i-th slice of the grid across its k-th axis, m²."""
    gap = ti.cast(0.0, ti.f64)
    # The outermost slices have no end.
    if i < counts[k] - 1:
        gap = ti.max(gap, picked(nearest, axes[k]) - (low[k] + (i + 1) * sides[k]))
    if i > 0:
        gap = ti.max(gap, low[k] + i * sides[k] - picked(farthest, axes[k]))
    return gap * gap


@ti.func
def add_near(
    rows: ti.template(),
    n,
    stop,
    b,
    target: ti.template(),
    nearest,
    farthest,
    reach2,
    end,
    limit,
    entries: ti.template(),
):
    """Put those of rows n to stop that are near one of the targets, in a box, behind a list; its new end."""
    total, own = end, b * rows.width
    for row in range(n, stop):
        p = rows.at[row]
        near = ti.i32(1)
        if ti.static(rows.axes == 2):
            # Sheets fill the boxes around packs: who is near the box is near one of them, and a scalar tells.
            gap = 0.0 * p[0]
            for c in ti.static(range(2)):
                beyond = ti.max(nearest[c] - p[c], ti.max(p[c] - farthest[c], 0.0))
                gap = gap + beyond * beyond
            near = ti.select(gap <= reach2, 1, 0)
        else:
            dx, dy, dz = target[0] - p[0], target[1] - p[1], target[2] - p[2]
            bits = ti.select(dx * dx + dy * dy + dz * dz <= reach2, 1, 0)
            near = bits[0]
            for k in ti.static(range(1, rows.width)):
                near = near | bits[k]
        # Written first and counted if near: a branch would be mispredicted every third time.
        entries[ti.min(total, limit - 1)] = row
        total += ti.select((near != 0) & ((row < own) | (row >= own + rows.width)), 1, 0)
    return total


@ti.func
def add_list(
    rows: ti.template(), crowd: ti.template(), grid: ti.template(), reach, b, begin, limit, entries: ti.template()
):
    """Put the list of pack b where it begins; its end.

    Args:
        rows: particles, then images; each in the order of the grid.
        crowd: count, whether there are images, and the first row of each bin, of particles and of images.
        grid: low, sides, counts, axes.
        reach: m.
        b: the pack.
        begin, limit: what belongs behind the limit is not kept.
        entries: filled.
    """
    count, imaged, starts, image_starts = ti.static(crowd)
    low, sides, counts, axes = ti.static(grid)
    target = targets(rows, b, count)
    reach2 = ti.cast(reach * reach, rows.real)
    nearest = ti.Vector([target[c].min() for c in ti.static(range(3))])
    farthest = ti.Vector([target[c].max() for c in ti.static(range(3))])
    inverse = 1.0 / sides
    first = [span(nearest - reach, k, low, inverse, counts, axes) for k in ti.static(range(2))]
    last = [span(farthest + reach, k, low, inverse, counts, axes) for k in ti.static(range(2))]
    end = begin
    for i in range(first[0], last[0] + 1):
        left = reach * reach - gap2(i, 0, low, sides, counts, axes, nearest, farthest)
        for j in range(first[1], last[1] + 1):
            rest = left - gap2(j, 1, low, sides, counts, axes, nearest, farthest)
            if rest >= 0.0:
                along = ti.sqrt(rest)
                one = number(i, j, span(nearest - along, 2, low, inverse, counts, axes), counts)
                other = number(i, j, span(farthest + along, 2, low, inverse, counts, axes), counts)
                n, stop = starts[ti.min(one, other)], starts[ti.max(one, other) + 1]
                end = add_near(rows, n, stop, b, target, nearest, farthest, reach2, end, limit, entries)
                if ti.static(imaged):
                    n = count + image_starts[ti.min(one, other)]
                    stop = count + image_starts[ti.max(one, other) + 1]
                    end = add_near(rows, n, stop, b, target, nearest, farthest, reach2, end, limit, entries)
    return end


@ti.kernel
def list_neighbors(
    rows: ti.template(),
    count: ti.i32,
    low: VECTOR3,
    sides: VECTOR3,
    counts: INDEX3,
    axes: INDEX3,
    reach: ti.f64,
    imaged: ti.template(),
    starts: INTEGERS,
    image_starts: INTEGERS,
    room: ti.i32,
    begins: INTEGERS,
    ends: INTEGERS,
    entries: INTEGERS,
    needs: INTEGERS,
):
    """For each pack the rows within reach of any of its particles, except those of the pack itself.

    The lists of a block of packs follow each other, so that they are read as a stream.

    Args:
        rows: particles, then images; each in the order of the grid.
        count: particles.
        low, sides, counts, axes: the grid.
        reach: m.
        imaged: whether there are images.
        starts, image_starts: the first row of each bin, of particles, and counted from `count` of images.
        room: entries of a block.
        begins, ends: filled: of each pack's list, among the entries.
        entries: filled, block by block.
        needs: filled: entries of each block; where they are not below the room, some are missing.
    """
    ti.loop_config(block_dim=1)
    for block in range(needs.shape[0]):
        place = block * room
        for b in range(block * BLOCK, ti.min((block + 1) * BLOCK, begins.shape[0])):
            crowd = ti.static((count, imaged, starts, image_starts))
            grid = ti.static((low, sides, counts, axes))
            begins[b] = place
            place = add_list(rows, crowd, grid, reach, b, place, (block + 1) * room, entries)
            ends[b] = place
        needs[block] = place - block * room

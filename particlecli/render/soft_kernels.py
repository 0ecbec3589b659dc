"""Splatting soft sprites into a pyramid, without atomics on light.

Records are sorted by (class, band of rows), see `soft_sorting`; then bands of all levels are splatted, the even ones in
parallel, then the odd ones. Each band adds up its records in the order of the particles, so the picture does not depend
on the number of threads.
"""

import taichi as ti

from particlecli.render.arrays import Integers, IntegerTable, Rows, vec4
from particlecli.render.binning import begin, clear_counts
from particlecli.render.layout import BANDS, BIN, MARGIN, OFFSET, PITCH
from particlecli.render.records import COLORS, END, FIRST, HALO, SMEARED
from particlecli.render.soft_sorting import sort, sort_smeared


@ti.func
def _weights(t):
    """Weights of the nodes −1, 0, 1 and 2 for a splat at t in 0..1: the mean of two quadratic B-splines.

    Sum 1, mean t and variance ½ for every t, like a slightly wider cubic B-spline; but as every other node
    gets half of the light, nothing is left at the level's highest frequency, where doubling would make
    large sprites pulsate as they move: by 2 % instead of a cubic B-spline's 15 %.
    """
    s = 1.0 - t
    first, last = 0.25 * s * s, 0.25 * t * t
    return vec4(first, 0.5 - last, 0.5 - first, last)


@ti.func
def _splat(light: ti.template(), start, pitch, x, y, color):
    left, top = ti.cast(x, ti.i32), ti.cast(y, ti.i32)
    across, down = _weights(x - left), _weights(y - top)
    node = start + (top - 1) * pitch + left - 1
    a, b, c, d = color * across[0], color * across[1], color * across[2], color * across[3]
    for j in ti.static(range(4)):
        row = node + j * pitch
        # All four are read before the first is written, so that they become wide registers. `light[row + i] += …` would
        # be an atomic, 20 times slower.
        first, second = light[row] + a * down[j], light[row + 1] + b * down[j]
        third, fourth = light[row + 2] + c * down[j], light[row + 3] + d * down[j]
        light[row], light[row + 1], light[row + 2], light[row + 3] = first, second, third, fourth


@ti.func
def _section(part, level, band, levels: ti.template()):
    """First and last bin of what a band draws: 0, sprites too small for level 0; 1, the level's own; 2, the finer's.

    Rows 16b − 8 … 16b + 8 of the finer level are rows 8b … 8b + 8 of this one, margins included.
    """
    first, end = 0, 0
    if part == 1:
        first = levels[level, BIN] + band
        end = first + 1
    elif part == 0 and level == 0:
        first, end = band, band + 1
    elif part == 2 and level > 0:
        first = levels[level - 1, BIN] + ti.max(2 * band - 1, 0)
        end = ti.max(levels[level - 1, BIN] + ti.min(2 * band + 1, levels[level - 1, BANDS]), first)
    return first, end


@ti.func
def _splat_bin(
    part, bin_, level, light: ti.template(), levels: ti.template(), bins, chunks: ti.template(), counts: ti.template(),
    records: ti.template(), colors: ti.template(),
):  # fmt: skip
    """Add the light of a bin's records, chunk by chunk; counts tell where the records of each chunk end."""
    first = counts[chunks.shape[0] * bins + bin_]
    for chunk in range(chunks.shape[0]):
        end = counts[chunk * bins + bin_]
        tints, halo = ti.cast(chunks[chunk, COLORS], ti.i32), chunks[chunk, HALO]
        for o in range(first, end):
            record = records[o]
            x, y = record[0], record[1]
            place = ti.cast(record[2], ti.i32)
            fraction = record[2] - place
            share, marked = fraction, halo
            if part == 0:
                share, marked = 1.0, halo * fraction
            elif part == 1:
                share = 1.0 - fraction
            else:
                x, y = 0.5 * x + 0.5 * MARGIN, 0.5 * y + 0.5 * MARGIN
            tint = tints + place
            color = vec4(colors[tint, 0], colors[tint, 1], colors[tint, 2], colors[tint, 3] * marked)
            _splat(light, levels[level, OFFSET], levels[level, PITCH], x, y, color * (record[3] * share))
        first = end


@ti.func
def _splat_task(
    task, parity, light: ti.template(), levels: ti.template(), bins, chunks: ti.template(), counts: ti.template(),
    records: ti.template(), colors: ti.template(),
):  # fmt: skip
    """Splat one of the bands, of all levels, that are even or odd, section by section: no two of them overlap."""
    level, band = 0, 2 * task + parity
    while band >= levels[level, BANDS]:
        band -= (levels[level, BANDS] + 1 - parity) // 2 * 2
        level += 1
    for part in range(3):
        first, end = _section(part, level, band, levels)
        for bin_ in range(first, end):
            _splat_bin(part, bin_, level, light, levels, bins, chunks, counts, records, colors)


@ti.func
def _bins(levels: ti.template(), last):
    return levels[last, BIN] + levels[last, BANDS]


@ti.kernel
def sort_soft(
    chunks: Rows, which: ti.i32, sprites: ti.template(), records: ti.template(), counts: ti.template(),
    levels: IntegerTable, last: ti.i32, total: Integers, placing: ti.i32,
):  # fmt: skip
    """Count the records that sprites make, or, once that is done, put them in their places.

    Args:
        chunks: of sprites, see `records`.
        which: their set.
        sprites, records, counts: see `Store`.
        levels: see `layout`.
        last: the coarsest level.
        total: shape (1,), becomes how many records there are.
        placing: whether to place them, for which there must be room.
    """
    bins = _bins(levels, last)
    ti.loop_config(block_dim=1)
    for chunk in range(chunks.shape[0]):
        first, end = ti.cast(chunks[chunk, FIRST], ti.i32), ti.cast(chunks[chunk, END], ti.i32)
        if not placing:
            clear_counts(chunk, bins, counts)
        if chunks[chunk, SMEARED] > 0.0:
            sort_smeared(chunk * bins, first, end, which, sprites, levels, counts, records, last, placing)
        else:
            sort(chunk * bins, first, end, which, sprites, levels, counts, records, last, placing)
    ti.loop_config(serialize=True)
    for _ in range(1):
        if not placing:
            total[0] = begin(chunks.shape[0], bins, counts)


@ti.kernel
def splat(
    chunks: Rows, records: ti.template(), counts: ti.template(), levels: IntegerTable, last: ti.i32,
    light: ti.template(), colors: Rows, parity: ti.i32, tasks: ti.i32,
):  # fmt: skip
    """Add the light of sorted records to a pyramid's, in the bands that are even (parity 0) or odd (1).

    Args:
        chunks, records, counts, levels, last: as they were sorted.
        colors: tables of all tints.
        tasks: how many of such bands all levels have.
    """
    bins = _bins(levels, last)
    ti.loop_config(block_dim=1)
    for task in range(tasks):
        _splat_task(task, parity, light, levels, bins, chunks, counts, records, colors)

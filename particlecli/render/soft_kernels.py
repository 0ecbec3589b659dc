"""Splatting soft sprites into a pyramid, without atomics on light.

Records are sorted by (class, band of rows), see `soft_sorting`; then bands of all levels are splatted, the even ones in
parallel, then the odd ones. Each band adds up its records in the order of the particles, so the picture does not depend
on the number of threads.
"""

import taichi as ti

from particlecli.render.arrays import Integers, IntegerTable, Rows, vec4
from particlecli.render.binning import begin, clear_counts
from particlecli.render.layout import BANDS, BIN, MARGIN, OFFSET, PITCH
from particlecli.render.soft_sorting import sort, sort_smeared
from particlecli.render.tasks import CHUNK, GRAIN, LANES


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
def _splat_band(
    level, band, light: ti.template(), levels: ti.template(), starts, counts: ti.template(), records: ti.template(),
    colors: ti.template(), halo,
):  # fmt: skip
    """Add a band's light, section by section; from place `starts` on counts tell where bins begin."""
    for part in range(3):
        first, end = _section(part, level, band, levels)
        for o in range(counts[starts + first], counts[starts + end]):
            record = records[o]
            x, y = record[0], record[1]
            tint = ti.cast(record[2], ti.i32)
            fraction = record[2] - tint
            share, marked = fraction, halo
            if part == 0:
                share, marked = 1.0, halo * fraction
            elif part == 1:
                share = 1.0 - fraction
            else:
                x, y = 0.5 * x + 0.5 * MARGIN, 0.5 * y + 0.5 * MARGIN
            color = vec4(colors[tint, 0], colors[tint, 1], colors[tint, 2], colors[tint, 3] * marked)
            _splat(light, levels[level, OFFSET], levels[level, PITCH], x, y, color * (record[3] * share))


@ti.func
def _splat_task(
    task, parity, light: ti.template(), levels: ti.template(), starts, counts: ti.template(), records: ti.template(),
    colors: ti.template(), halo,
):  # fmt: skip
    """Splat one of the bands, of all levels, that are even or odd: no two of them overlap."""
    level, band = 0, 2 * task + parity
    while band >= levels[level, BANDS]:
        band -= (levels[level, BANDS] + 1 - parity) // 2 * 2
        level += 1
    _splat_band(level, band, light, levels, starts, counts, records, colors, halo)


@ti.func
def _tasks(parity, last, levels: ti.template()):
    """How many bands of all levels are even, or odd."""
    total = 0
    for level in range(last + 1):
        total += (levels[level, BANDS] + 1 - parity) // 2
    return total


@ti.kernel
def draw_soft(
    first: ti.i32, end: ti.i32, which: ti.i32, sprites: ti.template(), records: ti.template(), counts: ti.template(),
    room: ti.i32, levels: IntegerTable, last: ti.i32, light: ti.template(), colors: Rows, halo: ti.f32,
    counter: Integers, smeared: ti.i32,
):  # fmt: skip
    """Add sprites to a pyramid's light, if there is room for their records.

    Args:
        first, end: the first sprite of the set, a multiple of PACK, and the one behind the last.
        which: the set.
        sprites, records, counts, room: see `Store`.
        levels: see `layout`.
        last: the coarsest level.
        colors: a tint's table.
        halo: share of the light that forms a halo around each sprite.
        counter: shape (2,); the second number tells how many records it takes.
        smeared: whether to draw tails.
    """
    chunks = (end - first + CHUNK - 1) // CHUNK
    bins = levels[last, BIN] + levels[last, BANDS]
    counter[0] = 0
    for lane in range(LANES):
        if lane % GRAIN == 0:
            chunk = ti.atomic_add(counter[0], 1)
            while chunk < chunks:
                start = first + chunk * CHUNK
                stop = ti.min(end, start + CHUNK)
                clear_counts(chunk, bins, counts)
                if smeared:
                    sort_smeared(chunk * bins, start, stop, which, sprites, levels, counts, records, last, False)
                else:
                    sort(chunk * bins, start, stop, which, sprites, levels, counts, records, last, False)
                chunk = ti.atomic_add(counter[0], 1)
    ti.loop_config(serialize=True)
    for _ in range(1):
        counter[1] = begin(chunks, bins, counts)
        counter[0] = 0 if counter[1] <= room else chunks
    for lane in range(LANES):
        if lane % GRAIN == 0:
            chunk = ti.atomic_add(counter[0], 1)
            while chunk < chunks:
                start = first + chunk * CHUNK
                stop = ti.min(end, start + CHUNK)
                if smeared:
                    sort_smeared(chunk * bins, start, stop, which, sprites, levels, counts, records, last, True)
                else:
                    sort(chunk * bins, start, stop, which, sprites, levels, counts, records, last, True)
                chunk = ti.atomic_add(counter[0], 1)
    even, odd = _tasks(0, last, levels), _tasks(1, last, levels)
    counter[0] = 0 if counter[1] <= room else even
    for lane in range(LANES):
        if lane % GRAIN == 0:
            task = ti.atomic_add(counter[0], 1)
            while task < even:
                _splat_task(task, 0, light, levels, chunks * bins, counts, records, colors, halo)
                task = ti.atomic_add(counter[0], 1)
    counter[0] = 0 if counter[1] <= room else odd
    for lane in range(LANES):
        if lane % GRAIN == 0:
            task = ti.atomic_add(counter[0], 1)
            while task < odd:
                _splat_task(task, 1, light, levels, chunks * bins, counts, records, colors, halo)
                task = ti.atomic_add(counter[0], 1)

"""Sorting discs by the bands of rows they touch, and drawing them with antialiased edges.

A record is x, y, the radius of the filtered disc and the number of its sprite.

The light of a disc is filtered with a quadratic B-spline, ¾ − d² near its middle, which keeps its energy and
centroid exactly wherever it lies between pixels. A disc of the wanted radius R has the variance R²/4 and the
filter ¼, so a disc of radius √(R² − 1) is filtered; below one pixel a point is left. Each band draws the rows
of its own discs that lie in it, so bands never meet and all are drawn in parallel.
"""

import taichi as ti

from particlecli.render.arrays import Integers, Rows, vec3, vec4
from particlecli.render.binning import begin, clear_counts
from particlecli.render.layout import BAND, MARGIN
from particlecli.render.records import COLORS, END, FIRST, HALO
from particlecli.render.sprites import ENERGY, PACK, RADIUS, TINT, X, Y

FILTER = 1.5
"""Reach of the filter, pixels."""

SPAN_STEP = 0.6
"""Greatest distance of the horizontal spans that a disc is made of, pixels."""


@ti.func
def _inner_radius(radius):
    return ti.sqrt(ti.max(radius * radius - 1.0, 0.0))


@ti.func
def _sort(
    place_of_bins, first, end, which, sprites: ti.template(), counts: ti.template(), records: ti.template(),
    pitch, bands, placing,
):  # fmt: skip
    """Take discs to the bands they touch: count the records, or put them where the counts say."""
    for i in range(first, end):
        b, lane = i // PACK, i % PACK
        radius = _inner_radius(sprites[which, RADIUS, b][lane])
        x, y = sprites[which, X, b][lane] + MARGIN, sprites[which, Y, b][lane] + MARGIN
        reach = radius + FILTER
        inside = (x > -reach) & (x < pitch + reach) & (y > -reach) & (y < bands * BAND + reach)
        if (sprites[which, ENERGY, b][lane] > 0.0) & inside:
            top = ti.max(ti.cast(ti.floor(y - reach), ti.i32) // BAND, 0)
            bottom = ti.min(ti.cast(ti.floor(y + reach), ti.i32) // BAND + 1, bands)
            for k in range(place_of_bins + top, place_of_bins + bottom):
                place = counts[k]
                counts[k] = place + 1
                if placing:
                    records[place] = vec4(x, y, radius, i)


@ti.func
def _filter(d):
    """Quadratic B-spline at the pixels −1, 0 and 1 from the nearest one, for a point at d in −½..½."""
    return vec3(0.5 * (0.5 - d) * (0.5 - d), 0.75 - d * d, 0.5 * (0.5 + d) * (0.5 + d))


@ti.func
def _filtered_before(u):
    """Integral of the quadratic B-spline up to u."""
    d = ti.min(ti.max(u, -FILTER), FILTER)
    flank = ti.max(FILTER - ti.abs(d), 0.0)
    outer = flank * flank * flank * (1.0 / 6.0)
    inner = 0.5 + 0.75 * d - d * d * d * (1.0 / 3.0)
    return ti.select(ti.abs(d) < 0.5, inner, ti.select(d < 0.0, outer, 1.0 - outer))


@ti.func
def _draw_point(light: ti.template(), start, pitch, top, x, y, color):
    column, row = ti.cast(x + 0.5, ti.i32), ti.cast(y + 0.5, ti.i32)
    across, down = _filter(x - column), _filter(y - row)
    if (column >= 1) & (column < pitch - 1):
        for j in ti.static(range(3)):
            line = row + j - 1
            if (line >= top) & (line < top + BAND):
                for i in ti.static(range(3)):
                    node = start + line * pitch + column + i - 1
                    light[node] = light[node] + color * (down[j] * across[i])


@ti.func
def _draw_disc(light: ti.template(), start, pitch, top, x, y, radius, color):
    spans = ti.cast(2.0 * radius / SPAN_STEP, ti.i32) + 2
    step = 2.0 * radius / spans
    area = 0.0
    for k in range(spans):
        offset = (k + 0.5) * step - radius
        area = area + ti.sqrt(radius * radius - offset * offset)
    for k in range(spans):
        offset = (k + 0.5) * step - radius
        half = ti.sqrt(radius * radius - offset * offset)
        row = ti.cast(ti.floor(y + offset + 0.5), ti.i32)
        if (row + 1 >= top) & (row - 1 < top + BAND):
            down = _filter(y + offset - row) * (0.5 / area)
            left = ti.max(ti.cast(ti.ceil(x - half - FILTER), ti.i32), 0)
            right = ti.min(ti.cast(ti.floor(x + half + FILTER), ti.i32) + 1, pitch)
            for column in range(left, right):
                covered = _filtered_before(column - x + half) - _filtered_before(column - x - half)
                for j in ti.static(range(3)):
                    line = row + j - 1
                    if (line >= top) & (line < top + BAND):
                        node = start + line * pitch + column
                        light[node] = light[node] + color * (covered * down[j])


@ti.func
def _draw_record(
    record, light: ti.template(), start, pitch, top, which, sprites: ti.template(), tints, halo, colors: ti.template()
):  # fmt: skip
    """Draw one disc's rows in the band that begins at row `top`."""
    number = ti.cast(record[3], ti.i32)
    b, at = number // PACK, number % PACK
    tint = tints + ti.cast(sprites[which, TINT, b][at] + 0.5, ti.i32)
    color = vec4(colors[tint, 0], colors[tint, 1], colors[tint, 2], colors[tint, 3] * halo)
    color = color * sprites[which, ENERGY, b][at]
    if record[2] > 0.0:
        _draw_disc(light, start, pitch, top, record[0], record[1], record[2], color)
    else:
        _draw_point(light, start, pitch, top, record[0], record[1], color)


@ti.kernel
def sort_discs(
    chunks: Rows, which: ti.i32, sprites: ti.template(), records: ti.template(), counts: ti.template(),
    pitch: ti.i32, bands: ti.i32, total: Integers, placing: ti.i32,
):  # fmt: skip
    """Count the records that discs make, or, once that is done, put them in their places.

    Args:
        chunks: of sprites, see `records`.
        which: their set.
        sprites, records, counts: see `Store`.
        pitch, bands: nodes in a row, and bands, of the finest level.
        total: shape (1,), becomes how many records there are.
        placing: whether to place them, for which there must be room.
    """
    ti.loop_config(block_dim=1)
    for chunk in range(chunks.shape[0]):
        first, end = ti.cast(chunks[chunk, FIRST], ti.i32), ti.cast(chunks[chunk, END], ti.i32)
        if not placing:
            clear_counts(chunk, bands, counts)
        _sort(chunk * bands, first, end, which, sprites, counts, records, pitch, bands, placing)
    ti.loop_config(serialize=True)
    for _ in range(1):
        if not placing:
            total[0] = begin(chunks.shape[0], bands, counts)


@ti.kernel
def splat_discs(
    chunks: Rows, which: ti.i32, sprites: ti.template(), records: ti.template(), counts: ti.template(),
    pitch: ti.i32, bands: ti.i32, light: ti.template(), start: ti.i32, colors: Rows,
):  # fmt: skip
    """Add sorted discs to light, from node `start` on; `colors` has the tables of all tints."""
    ti.loop_config(block_dim=1)
    for band in range(bands):
        first = counts[chunks.shape[0] * bands + band]
        for chunk in range(chunks.shape[0]):
            end = counts[chunk * bands + band]
            tints, halo = ti.cast(chunks[chunk, COLORS], ti.i32), chunks[chunk, HALO]
            for o in range(first, end):
                _draw_record(
                    records[o], light, start, pitch, band * BAND, which, sprites, tints, halo, colors
                )  # fmt: skip
            first = end

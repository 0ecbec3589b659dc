"""Sorting soft sprites by size and place.

A sprite's size puts it between two levels of the pyramid. Class 0 holds sprites smaller than level 0 can
show, class c the ones between levels c − 1 and c. Records are sorted by (class, band of rows).

A record is (x, y, place in the tint's table + a fraction below 1, energy), x and y in nodes of the finer
level from the start of its buffer. The fraction is the share of the energy that the coarser level gets; for
class 0 the share of the halo that a sprite so small still has.
"""

import taichi as ti

from particlecli.render.arrays import vec2, vec4
from particlecli.render.layout import BAND, BIN, CLEARANCE, HEIGHT, MARGIN, WIDTH
from particlecli.render.sprites import ENERGY, PACK, RADIUS, TAIL_X, TAIL_Y, TINT, X, Y

SPACING = 0.8
"""Greatest distance between the splats that a smeared sprite is drawn with, nodes."""

MOST_SPLATS = 4096
"""No smeared sprite is drawn with more splats than this."""

_FRACTION = 0.9995
"""Greatest fraction in a record; rounding never carries it into the place."""


@ti.func
def classify(radius, last):
    """Classes of a pack of sprites and their fractions, from their radii in pixels; a disc has the variance radius²/4.

    A splat of level l has the variance (5·4^l − 2)/6, so with q = (6·variance + 2)/5 the level is log₄ q. Of
    what lies between two levels the fraction comes closest to a Gaussian, in the least-squares sense for
    variances 1, q/4^l and 4; neither the width nor the brightness of the middle then steps from the ideal by
    more than a quarter.
    """
    variance = 0.25 * radius * radius
    q = 1.2 * variance + 0.4
    level = ti.min(((ti.bit_cast(ti.cast(q, ti.f32), ti.i32) >> 23) - 127) >> 1, last)
    between = q * _power(-2 * level)
    fraction = (4.0 / 3.0) * (1.0 - 10.0 / ((between + 1.0) * (between + 4.0)))
    fraction = ti.select(level == last, 0.0, fraction)
    fraction = ti.select(level < 0, ti.sqrt(ti.sqrt(2.0 * variance)), fraction)
    return ti.max(level, -1) + 1, ti.min(fraction, _FRACTION)


@ti.func
def _power(exponent):
    """Powers of two."""
    return ti.bit_cast(ti.cast(127 + exponent, ti.i32) << 23, ti.f32)


@ti.func
def _band(x, y, level, levels: ti.template()):
    """Bands of splats on levels, from their places in nodes; −1 where nothing of them reaches the picture."""
    rounding = (1 << level) - 1
    right = ti.cast(((levels[0, WIDTH] + rounding) >> level) + (2 * MARGIN - CLEARANCE), ti.f32)
    bottom = ti.cast(((levels[0, HEIGHT] + rounding) >> level) + (2 * MARGIN - CLEARANCE), ti.f32)
    seen = (x >= CLEARANCE) & (y >= CLEARANCE) & (x < right) & (y < bottom)
    return ti.select(seen, ti.cast(y * (1.0 / BAND), ti.i32), -1)


@ti.func
def _first_bin(kind, levels: ti.template()):
    return levels[kind - 1, BIN] if kind > 0 else 0


@ti.func
def _take(counts: ti.template(), k):
    """Next place of a bin."""
    place = counts[k]
    counts[k] = place + 1
    return place


@ti.func
def sort(
    bins, first, end, which, sprites: ti.template(), levels: ti.template(), counts: ti.template(),
    records: ti.template(), last, placing,
):  # fmt: skip
    """Take sprites to the bins that begin at a place: count the records, or put them where the counts say."""
    for b in range(first // PACK, (end + PACK - 1) // PACK):
        energy = sprites[which, ENERGY, b]
        kind, fraction = classify(sprites[which, RADIUS, b], last)
        level = ti.max(kind - 1, 0)
        scale = _power(-level)
        x, y = sprites[which, X, b] * scale + MARGIN, sprites[which, Y, b] * scale + MARGIN
        band = ti.select(energy > 0.0, _band(x, y, level, levels), -1)
        tint = ti.floor(sprites[which, TINT, b] + 0.5) + fraction
        for lane in range(ti.min(PACK, end - b * PACK)):
            if band[lane] >= 0:
                place = _take(counts, bins + _first_bin(kind[lane], levels) + band[lane])
                if placing:
                    records[place] = vec4(x[lane], y[lane], tint[lane], energy[lane])


@ti.func
def sort_smeared(
    bins, first, end, which, sprites: ti.template(), levels: ti.template(), counts: ti.template(),
    records: ti.template(), last, placing,
):  # fmt: skip
    """The same for smeared sprites, each drawn as a row of them."""
    for b in range(first // PACK, (end + PACK - 1) // PACK):
        kinds, fractions = classify(sprites[which, RADIUS, b], last)
        for lane in range(ti.min(PACK, end - b * PACK)):
            energy, kind = sprites[which, ENERGY, b][lane], kinds[lane]
            if energy > 0.0:
                level = ti.max(kind - 1, 0)
                scale = _power(-level)
                tail = vec2(sprites[which, TAIL_X, b][lane], sprites[which, TAIL_Y, b][lane]) * scale
                steps = ti.cast(ti.min(tail.norm() / SPACING, MOST_SPLATS - 1.0), ti.i32) + 1
                tint = ti.floor(sprites[which, TINT, b][lane] + 0.5) + fractions[lane]
                for step in range(steps):
                    along = (step + 0.5) / steps
                    x = sprites[which, X, b][lane] * scale + MARGIN + tail[0] * along
                    y = sprites[which, Y, b][lane] * scale + MARGIN + tail[1] * along
                    band = _band(x, y, level, levels)
                    if band >= 0:
                        place = _take(counts, bins + _first_bin(kind, levels) + band)
                        if placing:
                            records[place] = vec4(x, y, tint, energy / steps)

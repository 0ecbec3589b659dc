"""The last step of a picture, row by row: light of all levels, exposure, tone, sky and encoding.

A row passes through a worker's own store three times: as light, pixel by pixel; as places in the table of
values, PACK pixels at once; as values. Each pass is straight-line code, which the compiler takes to SIMD. Then its
light on level 0 is taken away, while it is at hand: the next picture finds that level empty.
"""

import taichi as ti

from particlecli.render.arena import PACK
from particlecli.render.arrays import Image, Integers, IntegerTable, Rows, vec4
from particlecli.render.layout import CLEARANCE, MARGIN
from particlecli.render.spread import halo_share, refined
from particlecli.render.tasks import WORKERS
from particlecli.render.tone import BLEED, FRACTION, HIGHEST, LOWEST, MANTISSA

SMALLEST, LARGEST = 2.0**LOWEST, 2.0**HIGHEST * (1 - 2.0**-20)

_SINGLE = ti.types.vector(PACK, ti.f32)
_INTEGERS = ti.types.vector(PACK, ti.i32)

WORDS = 3 * PACK // 4
"""Words of four bytes that the values of PACK pixels take."""


@ti.func
def _light_row(
    y, worker, light: ti.template(), rows: ti.template(), origin, pitch, coarse, coarse_pitch, width, kept, exposure,
):  # fmt: skip
    """The light of one row of a collapsed pyramid, into a worker's row."""
    odd = y % 2 == 1
    node = origin + y * pitch
    above = coarse + (y // 2 - ti.select(odd, 0, 1)) * coarse_pitch - 1
    left = refined(light, above, coarse_pitch, odd)
    middle = refined(light, above + 1, coarse_pitch, odd)
    own = kept * exposure
    for j in range((width + 1) // 2):
        right = refined(light, above + j + 2, coarse_pitch, odd)
        here = light[node + 2 * j]
        beside = light[node + 2 * j + 1]
        even = (left + right) * (0.03125 * exposure) + middle * (0.1875 * exposure)
        rows[worker, 2 * j] = even + (here - here * halo_share(here)) * own
        rows[worker, 2 * j + 1] = (middle + right) * (0.125 * exposure) + (beside - beside * halo_share(beside)) * own
        left = middle
        middle = right


@ti.func
def _clear_row(y, light: ti.template(), origin, pitch):
    first = origin + y * pitch - MARGIN
    for node in range(first, first + pitch):
        light[node] = vec4(0.0)


@ti.func
def _component(rows: ti.template(), worker, first, k: ti.template()):
    """One component of PACK pixels of a worker's row."""
    return _SINGLE([rows[worker, first + i][k] for i in ti.static(range(PACK))])


@ti.func
def _single(image: ti.template(), y, first):
    """PACK pixels of a row of numbers."""
    return _SINGLE([image[y, first + i] for i in ti.static(range(PACK))])


@ti.func
def _tone_row(
    y, worker, rows: ti.template(), places: ti.template(), width, sky, soil, cover: ti.template(),
    seen_sky: ti.template(), grounded: ti.template(), bodied: ti.template(),
):  # fmt: skip
    """From light to places in the table of values; see `tone.bleed` and `tone.places`."""
    for p in range((width + PACK - 1) // PACK):
        red = _component(rows, worker, p * PACK, 0)
        green = _component(rows, worker, p * PACK, 1)
        blue = _component(rows, worker, p * PACK, 2)
        open_sky = 1.0 + 0.0 * red
        if ti.static(grounded):
            covered = _single(cover, y, p * PACK)
            red, green, blue = red + covered * soil[0], green + covered * soil[1], blue + covered * soil[2]
            open_sky = 1.0 - covered
        if ti.static(bodied):
            open_sky = _single(seen_sky, y, p * PACK)
        higher = ti.select(red > green, red, green)
        brightest = ti.select(higher > blue, higher, blue)
        share = BLEED * brightest / (1.0 + brightest)
        grey = (red + green + blue) * (share * (1.0 / 3.0))
        for k, primary in ti.static(((0, red), (1, green), (2, blue))):
            shown = primary * (1.0 - share) + grey + open_sky * sky[k]
            shown = ti.select(shown > SMALLEST, shown, SMALLEST)
            bits = ti.bit_cast(ti.cast(ti.select(shown < LARGEST, shown, LARGEST), ti.f32), ti.i32)
            places[worker, k, p] = (bits >> (23 - MANTISSA)) - ((127 + LOWEST) << MANTISSA)


@ti.func
def _encode_row(
    y, worker, places: ti.template(), width, encoding: ti.template(), noise: ti.template(), image: ti.template()
):  # fmt: skip
    """Values of a row from its places in the table, four bytes a word, WORDS words for PACK pixels.

    All words of a pack come before the first is written: whatever is written could be what is read next, for all that
    the compiler knows.
    """
    for four in range((width + 3) // 4):
        p, first = four // (PACK // 4), four % (PACK // 4) * 4
        words = ti.Vector([0, 0, 0])
        for i in ti.static(range(4)):
            added = noise[y, 4 * four + i]
            for k in ti.static(range(3)):
                value = (encoding[places[worker, k, p][first + i]] + added) >> FRACTION
                words[(3 * i + k) // 4] |= value << ((3 * i + k) % 4 * 8)
        for word in ti.static(range(3)):
            image[y, 3 * four + word] = words[word]


@ti.kernel
def develop(
    light: ti.template(), rows: ti.template(), places: ti.template(), counter: Integers,
    origin: ti.i32, pitch: ti.i32, coarse: ti.i32, coarse_pitch: ti.i32, width: ti.i32, height: ti.i32,
    kept: ti.f32, exposure: ti.f32, sky: vec4, soil: vec4, cover: Rows, seen_sky: Rows, encoding: Integers,
    noise: IntegerTable, image: IntegerTable, grounded: ti.template(), bodied: ti.template(),
):  # fmt: skip
    """Values of a picture from the light of a collapsed pyramid, whose level 0 is emptied.

    Args:
        light, rows, places: see `Arena`.
        origin, coarse: nodes of the first pixel on level 0 and 1.
        kept: share of level 0's light that the lens does not scatter.
        sky: light of the sky, see `tone.sky_light`.
        soil: light of the ground, exposed.
        cover: shape (height, width or more): how much of each pixel is ground, and lit; whole packs.
        seen_sky: likewise, how much is sky; where there are no bodies, all but the ground.
        encoding: `tone.encoding_table`, in 2^-FRACTION of a value.
        noise: `tone.dither`, likewise, whole packs.
        image: shape (height, words): the bytes red, green, blue, red, …, whole packs of pixels.
    """
    counter[0] = 0
    ti.loop_config(block_dim=1)
    for worker in range(WORKERS):
        y = ti.atomic_add(counter[0], 1) - MARGIN
        while y < height + MARGIN + CLEARANCE:
            if (y >= 0) & (y < height):
                _light_row(y, worker, light, rows, origin, pitch, coarse, coarse_pitch, width, kept, exposure)
                _tone_row(y, worker, rows, places, width, sky, soil, cover, seen_sky, grounded, bodied)
                _encode_row(y, worker, places, width, encoding, noise, image)
            _clear_row(y, light, origin, pitch)
            y = ti.atomic_add(counter[0], 1) - MARGIN


@ti.kernel
def expose(
    light: ti.template(), rows: ti.template(), counter: Integers,
    origin: ti.i32, pitch: ti.i32, coarse: ti.i32, coarse_pitch: ti.i32, width: ti.i32, height: ti.i32,
    kept: ti.f32, image: Image,
):  # fmt: skip
    """Linear light of a collapsed pyramid, shape (height, width, 3), as `develop` sees it; level 0 is emptied too."""
    counter[0] = 0
    ti.loop_config(block_dim=1)
    for worker in range(WORKERS):
        y = ti.atomic_add(counter[0], 1) - MARGIN
        while y < height + MARGIN + CLEARANCE:
            if (y >= 0) & (y < height):
                _light_row(y, worker, light, rows, origin, pitch, coarse, coarse_pitch, width, kept, 1.0)
                for x in range(width):
                    for k in ti.static(range(3)):
                        image[y, x, k] = rows[worker, x][k]
            _clear_row(y, light, origin, pitch)
            y = ti.atomic_add(counter[0], 1) - MARGIN

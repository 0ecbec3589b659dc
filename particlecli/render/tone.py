"""From linear light to the values of a picture: a filmic curve, sRGB encoding, and the sky behind it all."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from particlecli.render.colour import decode, encode

Doubles = NDArray[np.float64]

SHOULDER = 0.75
"""Bends the curve so that light 1 becomes 0.7 of the picture's white."""

BLEED = 0.12
"""Share of very bright light that bleeds from each primary into the others, so that it turns white."""

LOWEST, HIGHEST = -17, 7
"""The encoding table reaches from light 2^LOWEST, 0.03 of a picture's steps, to 2^HIGHEST, white."""

MANTISSA = 9
"""Bits of a number's mantissa that choose a place: relative steps of 2^-9, at most 0.2 of a value."""

FRACTION = 16
"""Bits behind the point of values as kernels take them: whole numbers, which are added and cut without conversion."""

DITHER_MARGIN = 0.03
"""Keeps dithering away from whole values, so that they stay."""


def curve(light: NDArray[np.floating[Any]]) -> Doubles:
    """Display light in 0..1 of light: y / (y + ¾) with y = x (x + ¾).

    Slope 1 in the dark, 0.7 at 1, and on towards 1.
    """
    bent = light * (light + SHOULDER)
    return np.asarray(bent / (bent + SHOULDER), np.float64)


def uncurve(display: NDArray[np.floating[Any]]) -> Doubles:
    """The light that the curve takes to a display light in 0..1; white stands for the largest light."""
    shown = np.minimum(display, 0.99995)
    bent = SHOULDER * shown / (1.0 - shown)
    return np.asarray(np.sqrt(SHOULDER * SHOULDER / 4 + bent) - SHOULDER / 2, np.float64)


def bleed(light: NDArray[np.floating[Any]]) -> Doubles:
    """Light whose primaries bleed into each other, shape (…, 3).

    With m = max(r, g, b), the share BLEED · m / (1 + m) turns grey: dim colours stay exact, bright ones lose
    their hue gracefully.
    """
    brightest = light.max(axis=-1, keepdims=True)
    share = BLEED * brightest / (1.0 + brightest)
    return np.asarray(light + share * (light.mean(axis=-1, keepdims=True) - light), np.float64)


def picture(light: NDArray[np.floating[Any]], sky: NDArray[np.floating[Any]]) -> Doubles:
    """SRGB values in 0..255, not rounded, of light before a sky, both (…, 3); what `develop` computes."""
    return np.asarray(255.0 * encode(curve(bleed(light) + sky)), np.float64)


def sky_light(color: str) -> Doubles:
    """The light that comes out as a colour #rrggbb where nothing glows, shape (3,)."""
    return uncurve(decode(_values(color) / 255))


def dither(width: int, height: int) -> NDArray[np.float32]:
    """What to add to values before they are cut to whole ones, shape (height, width).

    Evenly spread, and different at neighbours (J. Jimenez, interleaved gradient noise, 2014).
    """
    x, y = np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32)[:, None]
    inner = np.float32(0.06711056) * x + np.float32(0.00583715) * y
    noise = np.float32(52.9829189) * (inner % 1) % 1
    return np.asarray(DITHER_MARGIN + (1 - 2 * DITHER_MARGIN) * noise, np.float32)


def encoding_table(sky: str) -> NDArray[np.float32]:
    """SRGB values in 0..255 by place in the table, with exactly the sky's values at the sky's places.

    A place is the exponent and the first MANTISSA bits of a 32-bit float, counted from light 2^LOWEST.
    """
    steps = 1 << MANTISSA
    octaves = 2.0 ** np.arange(LOWEST, HIGHEST)
    light = octaves[:, None] * (1.0 + (np.arange(steps) + 0.5) / steps)
    table = (255.0 * encode(curve(light.ravel()))).astype(np.float32)
    table[places(sky_light(sky))] = _values(sky)
    return table


def fixed(values: NDArray[np.float32]) -> NDArray[np.int32]:
    """Values in 2^-FRACTION of a picture's step."""
    return np.round(values.astype(np.float64) * 2.0**FRACTION).astype(np.int32)


def places(light: NDArray[np.floating[Any]]) -> NDArray[np.int64]:
    """Places of light in the encoding table."""
    inside = np.clip(light, 2.0**LOWEST, 2.0**HIGHEST * (1 - 2.0**-20)).astype(np.float32)
    bits: NDArray[np.int64] = inside.view(np.int32).astype(np.int64)
    return (bits >> (23 - MANTISSA)) - ((127 + LOWEST) << MANTISSA)


def _values(color: str) -> Doubles:
    digits = int(color.removeprefix("#"), 16)
    return np.array([digits >> 16, digits >> 8 & 255, digits & 255], np.float64)

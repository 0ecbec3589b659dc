"""Colour spaces: sRGB and its encoding, linear light, Oklab, and how to bring a colour into the gamut."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Doubles = NDArray[np.float64]

LUMINANCE = np.array([0.2126729, 0.7151522, 0.0721750])
"""Relative luminance of the sRGB primaries (ITU-R BT.709, D65)."""

XYZ_TO_SRGB = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)
"""CIE 1931 XYZ to linear sRGB, white D65 (IEC 61966-2-1)."""

_OKLAB_LMS = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_OKLAB_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)


def decode(encoded: ArrayLike) -> Doubles:
    """Linear light of sRGB values, both in 0..1 (IEC 61966-2-1)."""
    value = np.asarray(encoded, dtype=np.float64)
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def encode(linear: ArrayLike) -> Doubles:
    """SRGB values of linear light, both in 0..1 (IEC 61966-2-1)."""
    value = np.asarray(linear, dtype=np.float64)
    return np.where(value <= 0.0031308, value * 12.92, 1.055 * np.maximum(value, 1e-12) ** (1 / 2.4) - 0.055)


def from_hex(colors: str | Sequence[str]) -> Doubles:
    """Linear sRGB of one #rrggbb, shape (3,), or of several, shape (n, 3)."""
    if isinstance(colors, str):
        digits = int(colors.removeprefix("#"), 16)
        return decode(np.array([digits >> 16, digits >> 8 & 255, digits & 255]) / 255)
    return np.stack([from_hex(color) for color in colors])


def to_oklab(linear: NDArray[np.floating[Any]]) -> Doubles:
    """Oklab of linear sRGB, shape (…, 3), after B. Ottosson, A perceptual color space (2020)."""
    return np.asarray(np.cbrt(linear @ _OKLAB_LMS.T) @ _OKLAB_LAB.T, np.float64)


def from_oklab(lab: NDArray[np.floating[Any]]) -> Doubles:
    """Linear sRGB of Oklab, shape (…, 3); the inverse of `to_oklab`."""
    return np.asarray((lab @ np.linalg.inv(_OKLAB_LAB).T) ** 3 @ np.linalg.inv(_OKLAB_LMS).T, np.float64)


def into_gamut(linear: NDArray[np.floating[Any]]) -> Doubles:
    """Mix colours with the grey of their luminance, as little as needed, until no component is negative.

    Luminance and hue direction stay. Shape (…, 3); luminance must not be negative.
    """
    luminance = (linear @ LUMINANCE)[..., None]
    lowest = linear.min(axis=-1, keepdims=True)
    outside = lowest < 0
    share = np.where(outside, luminance / np.where(outside, luminance - lowest, 1.0), 1.0)
    return np.asarray(np.maximum(luminance + share * (linear - luminance), 0.0), np.float64)

"""The colour and brightness of a glowing body, from Planck's law and the CIE 1931 standard observer."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from particlecli.render.colour import XYZ_TO_SRGB, into_gamut

Doubles = NDArray[np.float64]

SECOND_RADIATION_CONSTANT = 1.438776877e-2
"""c₂ = hc/k, m K (CODATA 2018, exact)."""

_WAVELENGTHS = np.arange(360.0, 831.0, 1.0)  # nm


def _lobe(mean: float, below: float, above: float) -> Doubles:
    width = np.where(mean > _WAVELENGTHS, below, above)
    return np.asarray(np.exp(-0.5 * ((_WAVELENGTHS - mean) / width) ** 2))


def matching_functions() -> Doubles:
    """CIE 1931 2° matching functions x̄, ȳ, z̄ at 360, 361 … 830 nm, shape (3, 471).

    The multi-lobe fits of C. Wyman, P.-P. Sloan and P. Shirley, "Simple analytic approximations to the
    CIE XYZ color matching functions", JCGT 2(2), 2013, table 1.
    """
    x = 1.056 * _lobe(599.8, 37.9, 31.0) + 0.362 * _lobe(442.0, 16.0, 26.7) - 0.065 * _lobe(501.1, 20.4, 26.2)
    y = 0.821 * _lobe(568.8, 46.9, 40.5) + 0.286 * _lobe(530.9, 16.3, 31.1)
    z = 1.217 * _lobe(437.0, 11.8, 36.0) + 0.681 * _lobe(459.0, 26.0, 13.8)
    return np.stack([x, y, z])


def tristimulus(temperature: ArrayLike) -> Doubles:
    """CIE XYZ of a black body, in units that are the same for all temperatures.

    Planck's law, B(λ, T) ∝ λ⁻⁵ / (exp(c₂/λT) − 1), summed against the matching functions.

    Args:
        temperature: shape (…), K, positive.

    Returns:
        Shape (…, 3).
    """
    kelvin = np.asarray(temperature, dtype=np.float64)[..., None]
    metres = _WAVELENGTHS * 1e-9
    with np.errstate(over="ignore"):
        radiance = (500e-9 / metres) ** 5 / np.expm1(SECOND_RADIATION_CONSTANT / (metres * kelvin))
    return np.asarray(radiance @ matching_functions().T)


def chromaticity(temperature: ArrayLike) -> Doubles:
    """CIE 1931 x and y of a black body, shape (…, 2)."""
    xyz = tristimulus(temperature)
    return np.asarray(xyz[..., :2] / xyz.sum(axis=-1, keepdims=True))


def glow(temperature: ArrayLike, reference: float) -> Doubles:
    """Linear sRGB of a black body whose luminance is 1 at the reference temperature, shape (…, 3).

    Colours that sRGB cannot show (those below about 1900 K) are desaturated until it can; the luminance,
    which falls by a factor of 55 from 1500 K to 1200 K, is kept.
    """
    return into_gamut(tristimulus(temperature) / tristimulus(reference)[..., 1] @ XYZ_TO_SRGB.T)

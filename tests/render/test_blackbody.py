from __future__ import annotations

import numpy as np
import pytest

from particlecli.render.blackbody import chromaticity, glow, matching_functions, tristimulus
from particlecli.render.colour import LUMINANCE


def test_matching_functions_have_the_observers_peaks() -> None:
    x, y, z = matching_functions()
    wavelengths = np.arange(360, 831)
    assert wavelengths[y.argmax()] == pytest.approx(555, abs=3)
    assert y.max() == pytest.approx(1.0, abs=0.02)
    assert z.max() == pytest.approx(1.78, abs=0.05)
    assert x.sum() == pytest.approx(y.sum(), rel=0.01)  # equal-energy light is neutral
    assert z.sum() == pytest.approx(y.sum(), rel=0.01)


@pytest.mark.parametrize(
    ("temperature", "x", "y", "tolerance"),
    [
        (2000, 0.5267, 0.4133, 0.003),
        (2855.5, 0.44757, 0.40745, 0.0015),  # CIE standard illuminant A
        (4000, 0.3805, 0.3768, 0.002),
        (6500, 0.3135, 0.3237, 0.002),
        (10000, 0.2807, 0.2884, 0.002),
    ],
)
def test_chromaticities_are_those_of_the_planckian_locus(
    temperature: float, x: float, y: float, tolerance: float
) -> None:
    """Against G. Wyszecki and W. S. Stiles, Color Science; the tolerance is that of the fitted observer."""
    assert chromaticity(temperature) == pytest.approx([x, y], abs=tolerance)


def test_luminance_is_one_at_the_reference_and_falls_as_planck_says() -> None:
    assert glow(1500.0, 1500.0) @ LUMINANCE == pytest.approx(1.0)
    ratio = tristimulus(1200.0)[1] / tristimulus(1500.0)[1]
    assert glow(1200.0, 1500.0) @ LUMINANCE == pytest.approx(ratio, rel=1e-6)
    assert ratio == pytest.approx(1 / 55, rel=0.02)


def test_sparks_redden_as_they_cool_and_no_colour_leaves_the_gamut() -> None:
    colors = glow(np.linspace(700, 12000, 200), 1500.0)
    assert (colors >= 0).all()
    redness = colors[:, 0] / colors.sum(axis=1)
    assert (np.diff(redness) < 1e-9).all()

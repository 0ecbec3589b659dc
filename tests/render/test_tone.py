from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from particlecli.render.renderer import Renderer
from particlecli.render.tone import bleed, curve, encoding_table, picture, places, sky_light, uncurve
from tests.render.frames import frame, group, scene

GREYS = np.geomspace(1e-5, 1e5, 2000)


def test_the_curve_is_monotone_and_ends_at_white() -> None:
    shown = curve(GREYS)
    assert (np.diff(shown) > 0).all()
    assert shown[-1] == pytest.approx(1.0)
    assert shown[0] == pytest.approx(1e-5, rel=1e-3)
    assert curve(np.array(1.0)) == pytest.approx(0.7)


@given(st.floats(0, 50))
def test_uncurve_undoes_the_curve(light: float) -> None:
    assert uncurve(curve(np.array(light))) == pytest.approx(light, rel=1e-4, abs=1e-9)


def test_dim_colours_stay_and_bright_ones_turn_white() -> None:
    orange = np.array([1.0, 0.3, 0.02])
    assert bleed(orange * 1e-3) == pytest.approx(orange * 1e-3, rel=0.02)
    for primary in np.eye(3):
        assert picture(primary * 1e3, np.zeros(3)).min() > 250
        steps = picture(primary * GREYS[:, None], np.zeros(3))
        assert (np.diff(steps, axis=0) > -1e-9).all()


@given(st.integers(0, 2**24 - 1))
def test_the_skys_values_are_in_the_table(color: int) -> None:
    sky = f"#{color:06x}"
    values = [color >> 16, color >> 8 & 255, color & 255]
    assert encoding_table(sky)[places(sky_light(sky))].tolist() == values


def test_the_table_is_close_to_the_formula_everywhere() -> None:
    light = np.geomspace(2e-5, 120, 5000)
    exact = 255 * picture_value(light)
    assert np.abs(encoding_table("#05060a")[places(light)] - exact).max() < 0.2


def picture_value(light: np.ndarray) -> np.ndarray:
    return picture(np.zeros((len(light), 3)), np.repeat(light[:, None], 3, axis=1))[:, 0] / 255


@pytest.mark.parametrize("sky", ["#05060a", "#000000", "#ffffff", "#1a2233", "#8fb2d9", "#010203", "#fe8001"])
def test_an_empty_picture_is_the_sky(sky: str) -> None:
    image = Renderer(scene(background=sky, exposure=3.0)).render(frame(dust=group(np.zeros((0, 3)))))
    values = [int(sky[k : k + 2], 16) for k in (1, 3, 5)]
    assert (image == values).all()


def test_the_picture_is_the_light_toned() -> None:
    renderer = Renderer(scene(background="#203040", exposure=1.7, dust={"as": "glow", "pixels": 200, "brightness": 4}))
    lit = frame(dust=group([[0.2, 0.1, 0]]))
    expected = picture(1.7 * renderer.light(lit), sky_light("#203040"))
    assert np.abs(renderer.render(lit) - expected).max() < 1.25


def test_dithering_keeps_the_mean_of_a_dark_gradient() -> None:
    """Between two values both occur, in the right proportion."""
    renderer = Renderer(scene(size=(96, 96), background="#000000", bloom=0, dust={"as": "glow", "pixels": 2000}))
    dim = renderer.light(frame(dust=group([[0, 0, 0]])))[40:56, 40:56]
    level = 0.0011 / dim.mean()
    faint = Renderer(
        scene(size=(96, 96), background="#000000", exposure=float(level), dust={"as": "glow", "pixels": 2000})
    )
    image = faint.render(frame(dust=group([[0, 0, 0]])))[40:56, 40:56].astype(float)
    expected = picture(dim * level, np.zeros(3))
    assert len(np.unique(image)) > 1
    assert image.mean() == pytest.approx(expected.mean(), abs=0.15)

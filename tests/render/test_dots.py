from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from particlecli.render.renderer import Renderer
from tests.render.frames import centroid, frame, group, scene
from tests.render.test_glow import SIZE, at, place

OFFSETS = st.floats(-0.5, 0.5)


def dots(pixels: float) -> Renderer:
    return Renderer(scene(size=SIZE, dust={"as": "dots", "pixels": pixels * 720 / SIZE[1], "color": "#ffffff"}))


@pytest.mark.parametrize("pixels", [0.3, 1.0, 1.3, 2.0, 4.0, 20.0])
@settings(max_examples=15, deadline=None)
@given(x=OFFSETS, y=OFFSETS)
def test_place_energy_and_width_do_not_depend_on_where_between_pixels(pixels: float, x: float, y: float) -> None:
    renderer = dots(pixels)
    light = renderer.light(at(renderer, 80 + x, 60 + y))
    assert centroid(light) == pytest.approx((80 + x, 60 + y), abs=0.005)
    assert light[..., 0].sum() == pytest.approx(np.pi * pixels**2, rel=0.01)
    distance = np.arange(SIZE[0]) - 80 - x
    variance = float((light[..., 0].sum(axis=0) * distance**2).sum() / light[..., 0].sum())
    assert variance == pytest.approx(max(pixels**2 / 4, 0.25), rel=0.03)


def test_a_large_dot_is_flat_inside_and_crisp_at_its_edge() -> None:
    light = dots(20.0).light(at(dots(20.0), 80, 60))[60, :, 0]
    assert light[64:97] == pytest.approx([1.0] * 33, abs=0.02)
    assert light[104:].max() < 0.01
    assert light[55:].min() >= 0


def test_dots_across_many_bands_and_over_the_edge_are_whole() -> None:
    renderer = dots(30.0)
    light = renderer.light(at(renderer, 80, 0))[..., 0]
    assert light.sum() == pytest.approx(np.pi * 900 / 2, rel=0.03)
    assert light[:25, 80] == pytest.approx([1.0] * 25, abs=0.02)
    assert renderer.light(at(renderer, -40, 60)).sum() == 0


def test_dots_have_no_halo_and_add_up() -> None:
    renderer = dots(3.0)
    places = np.random.default_rng(4).uniform(40, 80, (30, 2))
    together = renderer.light(frame(dust=group([place(renderer.view, x, y) for x, y in places])))
    one_by_one = sum(renderer.light(at(renderer, x, y)).astype(np.float64) for x, y in places)
    assert together == pytest.approx(one_by_one, abs=1e-5)
    assert (together[:, 90:] == 0).all()

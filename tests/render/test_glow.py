"""Where the light of glowing sprites goes: its energy, its middle, its width."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from particlecli.frame import Frame
from particlecli.render.camera import View
from particlecli.render.renderer import Renderer
from tests.render.frames import LEVEL, centroid, frame, group, scene

SIZE = (160, 120)
OFFSETS = st.floats(-0.5, 0.5)


def at(renderer: Renderer, x: float, y: float) -> Frame:
    """A frame with one particle, in the plane z = 0, on a place of the picture."""
    return frame(dust=group([place(renderer.view, x, y)]))


def place(view: View, x: float, y: float) -> list[float]:
    scale = 4 / view.focal
    return [(x - view.center[0]) * scale, (view.center[1] - y) * scale, 0.0]


def glow(pixels: float, **look: object) -> Renderer:
    """`pixels` of this picture; no halo, so that all light stays in the core."""
    return Renderer(scene(size=SIZE, dust={"as": "glow", "pixels": pixels * 720 / SIZE[1], "color": "#ffffff"}, **look))


@pytest.fixture(autouse=True)
def _no_halo(monkeypatch: pytest.MonkeyPatch) -> None:
    from particlecli.render.looks.glow import Glow

    monkeypatch.setattr(Glow, "halo", 0.0)


@pytest.mark.parametrize("pixels", [0.2, 1.0, 1.9, 4.0, 9.0, 15.0])
@settings(max_examples=15, deadline=None)
@given(x=OFFSETS, y=OFFSETS)
def test_place_energy_and_width_do_not_depend_on_where_between_pixels(pixels: float, x: float, y: float) -> None:
    renderer = glow(pixels)
    light = renderer.light(at(renderer, 80 + x, 60 + y))
    assert centroid(light) == pytest.approx((80 + x, 60 + y), abs=0.005)
    assert light[..., 0].sum() == pytest.approx(np.pi * pixels**2, rel=0.01)
    distance = np.arange(SIZE[0]) - 80 - x
    deviation = np.sqrt(float((light[..., 0].sum(axis=0) * distance**2).sum() / light[..., 0].sum()))
    assert deviation == pytest.approx(max(pixels / 2, np.sqrt(0.5)), rel=0.25)


def test_a_tenth_of_a_pixel_moves_the_centroid_by_a_tenth() -> None:
    renderer = glow(3.0)
    places = [centroid(renderer.light(at(renderer, 70 + 0.1 * step, 50)))[0] for step in range(11)]
    assert np.diff(places) == pytest.approx([0.1] * 10, abs=0.005)


def test_size_varies_continuously_through_the_levels() -> None:
    """Per unit of light, the middle dims steadily as a sprite grows."""
    sizes = np.geomspace(1.5, 16, 30)
    peaks = [glow(size).light(at(glow(size), 80, 60)).max() / size**2 for size in sizes]
    assert (np.diff(peaks) < 0).all()
    assert np.array(peaks) * sizes**2 == pytest.approx([2.0] * 30, rel=0.2)


def test_large_sprites_do_not_pulsate_as_they_move() -> None:
    renderer = glow(12.0)
    peaks = [renderer.light(at(renderer, 70 + step, 60)).max() for step in range(17)]
    assert min(peaks) > 0.95 * max(peaks)


def test_light_adds_up() -> None:
    renderer = glow(2.5)
    places = np.random.default_rng(4).uniform(40, 80, (30, 2))
    together = renderer.light(frame(dust=group([place(renderer.view, x, y) for x, y in places])))
    one_by_one = sum(renderer.light(at(renderer, x, y)).astype(np.float64) for x, y in places)
    assert together == pytest.approx(one_by_one, abs=1e-5)


def test_light_that_leaves_the_picture_leaves_without_a_step() -> None:
    renderer = glow(8.0)
    totals = [renderer.light(at(renderer, x, 60)).sum() for x in np.arange(-45, 20, 1.0)]
    assert totals[0] == 0
    assert (np.diff(totals) >= -1e-3).all()
    assert np.diff(totals).max() < 0.15 * max(totals)


def test_a_halo_moves_light_outwards_and_keeps_it(monkeypatch: pytest.MonkeyPatch) -> None:
    renderer = glow(3.0)
    core = renderer.light(at(renderer, 80, 60))
    from particlecli.render.looks.glow import Glow

    monkeypatch.setattr(Glow, "halo", 0.35)
    haloed = renderer.light(at(renderer, 80, 60))
    assert haloed[60, 80, 0] < 0.75 * core[60, 80, 0]
    assert haloed[60, 95, 0] > 100 * max(core[60, 95, 0], 1e-6)
    assert 0.97 < haloed.sum() / core.sum() < 1.0  # some of it leaves the picture
    assert centroid(haloed) == pytest.approx((80, 60), abs=0.1)


def test_halos_scale_with_their_sprites_and_vanish_with_them(monkeypatch: pytest.MonkeyPatch) -> None:
    from particlecli.render.looks.glow import Glow

    shares = []
    for pixels in (0.1, 0.5, 1.4, 4.0):
        monkeypatch.setattr(Glow, "halo", 0.0)
        core = glow(pixels).light(at(glow(pixels), 80, 60)).max()
        monkeypatch.setattr(Glow, "halo", 0.35)
        shares.append(1 - glow(pixels).light(at(glow(pixels), 80, 60)).max() / core)
    assert shares[0] < 0.12 < shares[1] < 0.25 < shares[2]
    assert shares[3] == pytest.approx(shares[2], abs=0.03)


def test_bloom_takes_its_share_and_keeps_the_light() -> None:
    sharp, soft = glow(1.0), glow(1.0, bloom=0.3)
    before, after = sharp.light(at(sharp, 80, 60)), soft.light(at(soft, 80, 60))
    assert 0.69 < after.max() / before.max() < 0.8
    assert after.sum() == pytest.approx(before.sum(), rel=0.02)


def test_the_camera_sees_energy_fall_with_distance_squared() -> None:
    renderer = Renderer(scene(size=SIZE, dust={"as": "glow", "radius": 0.02, "color": "#ffffff"}))
    near, far = (renderer.light(frame(dust=group([[0, 0, z]]))).sum() for z in (2.0, -4.0))
    assert near / far == pytest.approx((8 / 2) ** 2, rel=0.01)


def test_pixels_do_not_depend_on_distance_and_scale_with_the_picture() -> None:
    style = {"as": "glow", "pixels": 12, "color": "#ffffff"}
    energies = []
    for size in ((160, 120), (320, 240)):
        renderer = Renderer(scene(size=size, dust=style))
        energies += [renderer.light(frame(dust=group([[0, 0, z]]))).sum() for z in (2.0, -4.0)]
    assert energies[1] == pytest.approx(energies[0], rel=1e-3)
    assert energies[2] == pytest.approx(4 * energies[0], rel=0.01)


def test_particles_behind_or_at_the_camera_are_not_seen() -> None:
    renderer = Renderer(scene(size=SIZE, dust={"as": "glow", "radius": 0.05}))
    places = [[0, 0, z] for z in (4.0, 4.01, 5, 400, np.nan, np.inf)] + [[np.nan, 0, 0], [1e30, 0, 0]]
    assert renderer.light(frame(dust=group(places))).sum() == 0


def test_particles_that_come_to_the_camera_fade() -> None:
    renderer = Renderer(scene(size=SIZE, dust={"as": "glow", "radius": 0.0005}, camera=LEVEL))
    nearing = [renderer.light(frame(dust=group([[0, 0, 4 - depth]]))).sum() for depth in (0.09, 0.06, 0.045, 0.04)]
    assert nearing[0] > 0
    assert nearing[3] == 0
    assert nearing[2] < nearing[1]


def test_halos_do_not_pulsate_as_their_sprites_move(monkeypatch: pytest.MonkeyPatch) -> None:
    from particlecli.render.looks.glow import Glow

    monkeypatch.setattr(Glow, "halo", 0.35)
    renderer = glow(2.0)
    around = []
    for step in range(32):
        light = renderer.light(at(renderer, 60 + step, 60))[..., 0]
        around.append(light[[40, 80, 60, 60], 60 + step + np.array([0, 0, -20, 20])].mean())
    assert max(around) < 1.06 * min(around)

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from particlecli.frame import Frame
from particlecli.render import painter
from particlecli.render.camera import View
from particlecli.render.ground import facing_planes
from particlecli.render.renderer import Renderer
from particlecli.scene.camera import Camera
from particlecli.scene.planes import Plane
from tests.render.frames import centroid, frame, group, scene

CAMERA = {"position": [0, 1.5, 5], "look_at": [0, 1.0, 0]}
SIZE = (160, 120)
FLOOR = Plane(point=(0, 0, 0), normal=(0, 1, 0))
VIEW = View.of(Camera(position=(0, 1.5, 5), look_at=(0, 1.0, 0)), *SIZE)
STYLE = {"as": "glow", "radius": 0.05, "color": "#ffffff"}


def ground(**options: Any) -> dict[str, Any]:
    return {"brightness": 0, "reflection": 0, **options}


def renderer(planes: tuple[dict[str, Any], ...] = ({},), **look: Any) -> Renderer:
    return Renderer(scene(size=SIZE, camera=CAMERA, planes=planes, **{"dust": STYLE, **look}))


def test_a_plane_seen_from_behind_or_out_of_sight_is_not_drawn() -> None:
    below = Plane(point=(0, 3, 0), normal=(0, 1, 0))
    behind = Plane(point=(0, 0, 9), normal=(0, 0, -1))
    assert facing_planes([below], VIEW, None) == []
    assert facing_planes([behind], VIEW, None) == []


def test_planes_that_coincide_are_drawn_once() -> None:
    assert len(facing_planes([FLOOR, Plane(point=(3, 0, 1))], VIEW, None)) == 1


def test_the_ground_ends_softly_at_the_horizon() -> None:
    (floor,) = facing_planes([FLOOR], VIEW, 1e15)
    pixels, _ = VIEW.project(np.array([[0.0, 1.5, -1e6]]))
    horizon = pixels[0, 1]
    column = floor.cover[:, 80]
    assert (column[: int(horizon - 1)] == 0).all()
    assert column[int(horizon + 2) :] == pytest.approx(1.0, abs=1e-3)
    assert np.abs(120 - 0.5 - column.sum() - horizon) < 0.05


def test_haze_takes_the_ground_into_the_sky() -> None:
    (floor,) = facing_planes([FLOOR], VIEW, 10.0)
    column = floor.cover[:, 80]
    assert (np.diff(column) >= 0).all()
    (at_ten,), _ = VIEW.project(np.array([[0.0, 0.0, 5 - np.sqrt(100 - 1.5**2)]]))
    assert column[round(at_ten[1])] == pytest.approx(np.exp(-1), abs=0.1)


def test_walls_cut_each_other() -> None:
    """The floor of a room seen from outside ends at its walls."""
    room = [
        Plane(point=(0, 0, 0), normal=(0, 1, 0)),
        Plane(point=(-1, 0, 0), normal=(1, 0, 0)),
        Plane(point=(1, 0, 0), normal=(-1, 0, 0)),
        Plane(point=(0, 0, -1), normal=(0, 0, 1)),
        Plane(point=(0, 0, 1), normal=(0, 0, -1)),
    ]
    seen = facing_planes(room, VIEW, 1e9)
    assert len(seen) == 4  # all but the front wall, which is seen from behind
    total = np.sum([plane.cover for plane in seen], axis=0)
    assert total.max() < 1 + 1e-6
    (floor, *_) = seen
    inside, _ = VIEW.project(np.array([[0.0, 0.0, 0.0], [0.8, 0.0, 0.8]]))
    outside, _ = VIEW.project(np.array([[0.0, 0.0, 1.6], [1.6, 0.0, 0.0]]))
    for x, y in inside.round().astype(int):
        assert floor.cover[y, x] == pytest.approx(1.0, abs=0.02)
    for x, y in outside.round().astype(int):
        assert total[y, x] == pytest.approx(0.0, abs=0.02)
    assert np.array_equal(total, np.sum([p.cover for p in facing_planes(room[::-1], VIEW, 1e9)][::-1], axis=0))


def test_the_mirror_image_is_where_a_mirror_shows_it() -> None:
    lit = frame(dust=group([[0.4, 0.3, -0.5]]))
    dull = renderer(ground=ground(color="#000000"))
    mirror = renderer(ground=ground(color="#000000", reflection=1, roughness=0))
    seen = mirror.light(lit) - dull.light(lit)
    expected, _ = VIEW.project(np.array([[0.4, -0.3, -0.5]]))
    assert centroid(np.maximum(seen, 0)) == pytest.approx(tuple(expected[0]), abs=1.0)


def test_roughness_spreads_what_is_mirrored_and_height_more_so() -> None:
    def width(roughness: float, height: float) -> float:
        lit = frame(dust=group([[0, height, 0]]))
        seen = renderer(ground=ground(color="#000000", reflection=1, roughness=roughness)).light(lit)
        seen = (seen - renderer(ground=ground(color="#000000")).light(lit))[..., 0]
        return float((seen.sum() ** 2) / (seen.astype(np.float64) ** 2).sum())

    assert width(0.0, 0.5) < width(0.5, 0.5) < width(1.0, 0.5)
    assert width(0.5, 0.1) < width(0.5, 0.5)


def test_mirrored_light_does_not_leave_the_ground() -> None:
    lit = frame(dust=group([[0, 0.6, -3.0]]))
    mirror = renderer(ground=ground(reflection=1, roughness=1.0))
    seen = mirror.light(lit) - renderer(planes=()).light(lit)
    (floor,) = facing_planes([FLOOR], VIEW, None)
    assert np.abs(seen[floor.cover == 0]).max() < 1e-6


def test_a_glow_lights_the_ground_below_it() -> None:
    lit = frame(dust=group([[0, 0.3, 0]]))
    above = renderer(planes=()).light(lit)
    pool = renderer(ground=ground(color="#ffffff")).light(lit) - above
    half = renderer(ground=ground(color="#bcbcbc")).light(lit) - above
    (foot, beside, far), _ = VIEW.project(np.array([[0.0, 0.0, 0.0], [0.6, 0.0, 0.0], [1.5, 0.0, 0.0]]))
    values = [pool[round(y), round(x), 0] for x, y in (foot, beside, far)]
    assert values[0] > 2 * values[1] > 4 * values[2] > 0
    assert half.sum() == pytest.approx(pool.sum() / 2, rel=0.02)


def test_the_pool_holds_the_light_that_goes_down() -> None:
    """Half of 4π · πr² falls on the plane; a matt white plane throws E / π back to the camera."""
    view = {"position": [0, 20, 0], "look_at": [0, 0, 0], "up": [0, 0, -1], "field_of_view": 60}
    pictures = [
        Renderer(scene(size=SIZE, camera=view, planes=planes, dust=STYLE, ground=ground(color="#ffffff", haze=1e9)))
        for planes in ((), ({},))
    ]
    lit = frame(dust=group([[0, 1.0, 0]]))
    bare, floor = (picture.light(lit)[..., 0] for picture in pictures)
    pixel = 20 / pictures[0].view.focal
    flux = np.pi * (floor - bare).sum() * pixel**2
    assert flux == pytest.approx(2 * np.pi * np.pi * 0.05**2, rel=0.15)


def test_particles_behind_the_ground_are_hidden() -> None:
    shown = renderer(planes=()).light(frame(dust=group([[0, -0.5, 0]]))).sum()
    hidden = renderer(ground=ground()).light(frame(dust=group([[0, -0.5, 0]]))).sum()
    lying = renderer(ground=ground(color="#000000")).light(frame(dust=group([[0, 0.0, 0]]))).sum()
    assert shown > 0
    assert hidden == 0
    assert lying == pytest.approx(renderer(planes=()).light(frame(dust=group([[0, 0.0, 0]]))).sum(), rel=1e-3)


def test_invisible_ground_costs_and_changes_nothing() -> None:
    lit = frame(dust=group([[0, 0.5, 0], [0, -0.5, 0]]))
    invisible = renderer(ground={"visible": False})
    assert invisible._grounds == []
    assert np.array_equal(invisible.render(lit), renderer(planes=()).render(lit))


def test_the_soft_light_is_the_grounds_colour() -> None:
    picture = renderer(ground={"color": "#8090a0", "brightness": 0.2}, background="#000000")
    image = picture.render(frame(dust=group(np.zeros((0, 3)))))
    bottom = image[-1].mean(axis=0)
    assert bottom[0] < bottom[1] < bottom[2]
    assert image[:10].max() == 0


def test_the_ground_hides_the_sky() -> None:
    picture = renderer(ground={"color": "#000000", "haze": 1e9}, background="#c0d0e0")
    image = picture.render(frame(dust=group(np.zeros((0, 3)))))
    assert image[-1].max() == 0
    assert image[0].tolist() == [[0xC0, 0xD0, 0xE0]] * SIZE[0]


def test_planes_on_frames_are_drawn_where_they_are_at_each_instant() -> None:
    lift = {"lift": {"translate": [0, "0.3 + 0.4*t", 0], "rotate": {"axis": [0, 0, 1], "angle": "0.2*t"}}}
    look = {"ground": ground(color="#405060", reflection=0.6, brightness=0.3), "background": "#203040"}
    described = scene(size=SIZE, camera=CAMERA, planes=[{"frame": "lift"}], frames=lift, dust=STYLE, **look)
    moving = Renderer(described)
    dust = group([[0.3, 1.2, -0.5]])
    for time in (0.0, 0.5, 1.0):
        tilt = 0.2 * time
        there = {"point": [0, 0.3 + 0.4 * time, 0], "normal": [-math.sin(tilt), math.cos(tilt), 0]}
        still = renderer(planes=(there,), **look)
        found = moving.render(Frame(0, time, {"dust": dust})).copy()
        right = still.render(frame(dust=dust))
        assert np.ptp(right[..., 0]) > 20
        assert np.abs(found.astype(int) - right).max() <= 1


def test_some_particles_stand_for_all_in_mirrors_and_pools(monkeypatch: pytest.MonkeyPatch) -> None:
    places = np.random.default_rng(2).normal(size=(2000, 3)) * 0.2 + [0, 0.5, 0]
    lit = frame(dust=group(places))
    look = {"ground": ground(reflection=0.5), "dust": {**STYLE, "radius": 0.01}}
    every = renderer(**look).light(lit)
    monkeypatch.setattr(painter, "MIRRORED_AT_MOST", 500)
    monkeypatch.setattr(painter, "POOLED_AT_MOST", 250)
    some = renderer(**look).light(lit)
    bare = renderer(planes=(), **look).light(lit)
    assert not np.array_equal(some, every)
    assert (some - bare).sum() == pytest.approx((every - bare).sum(), rel=0.05)

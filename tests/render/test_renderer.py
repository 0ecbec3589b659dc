from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from particlecli import runtime
from particlecli.frame import GroupFrame
from particlecli.render import particles
from particlecli.render.renderer import Renderer
from particlecli.render.sprites import store_for
from tests.render.frames import frame, group, scene

PLACES = np.random.default_rng(3).uniform(-1, 1, (500, 3))


def dust(**fields: Any) -> GroupFrame:
    return group(PLACES, **fields)


def test_the_picture_has_the_scenes_resolution_or_the_one_asked_for() -> None:
    assert Renderer(scene(size=(70, 50))).render(frame(dust=dust())).shape == (50, 70, 3)
    assert Renderer(scene(size=(70, 50)), 33, 17).render(frame(dust=dust())).shape == (17, 33, 3)


@pytest.mark.parametrize(
    ("style", "fields"),
    [
        ({}, set()),
        ({"as": "hidden", "color": "blackbody"}, set()),
        ({"color": "blackbody"}, {"temperatures"}),
        ({"color": {"by": "speed", "map": "ice", "range": [0, 1]}}, {"velocities"}),
        ({"fade_out": 0.5}, {"ages", "lifetimes"}),
        ({"as": "streaks", "color": "blackbody"}, {"velocities", "ages", "temperatures"}),
    ],
)
def test_frames_carry_only_what_a_look_needs(style: dict[str, Any], fields: set[str]) -> None:
    assert Renderer(scene(dust=style)).needs("dust") == fields


def test_hidden_groups_are_not_drawn_and_groups_add_up() -> None:
    both = scene("left", "right", left={"color": "#ff0000"}, right={"color": "#0000ff"})
    one = scene("left", "right", left={"color": "#ff0000"}, right={"as": "hidden"})
    lit = frame(left=group([[-0.3, 0, 0]]), right=group([[0.3, 0, 0]]))
    assert Renderer(one).light(lit)[..., 2].sum() == 0
    light = Renderer(both).light(lit)
    assert light[..., 0].sum() == pytest.approx(light[..., 2].sum(), rel=0.01)


@pytest.mark.parametrize(
    ("color", "fields"),
    [
        (
            {"by": "speed", "map": ["#ff0000", "#0000ff"], "range": [1, 3]},
            {"velocities": [[0, 0, 1], [0, 3, 0]]},
        ),
        (
            {"by": "temperature", "map": ["#ff0000", "#0000ff"], "range": [300, 900]},
            {"temperatures": [200, 900]},
        ),
        ({"by": "age", "map": ["#ff0000", "#0000ff"]}, {"ages": [0, 4], "lifetimes": [4, 4]}),
        ({"by": "age", "map": ["#ff0000", "#0000ff"], "range": [1, 2]}, {"ages": [1, 2]}),
        ({"by": "id", "map": ["#ff0000", "#0000ff"], "range": [0, 7]}, {"ids": [0, 7]}),
    ],
)
def test_colours_follow_what_they_are_mapped_from(color: dict[str, Any], fields: dict[str, Any]) -> None:
    light = Renderer(scene(dust={"color": color})).light(frame(dust=group([[-0.7, 0, 0], [0.7, 0, 0]], **fields)))
    left, right = light[:, :32].sum(axis=(0, 1)), light[:, 32:].sum(axis=(0, 1))
    assert left[0] > 50 * left[2]
    assert right[2] > 50 * right[0]


def test_a_missing_field_is_named() -> None:
    with pytest.raises(ValueError, match="temperatures"):
        Renderer(scene(dust={"color": "blackbody"})).render(frame(dust=dust()))


def test_cooling_sparks_dim_by_planck() -> None:
    renderer = Renderer(scene(dust={"color": {"blackbody": 1500}}))
    hot, cool = (renderer.light(frame(dust=group([[0, 0, 0]], temperatures=[t]))).sum() for t in (1500, 1200))
    assert 30 < hot / cool < 60


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_broken_numbers_do_not_break_the_picture(value: float) -> None:
    broken = [value, 1000.0]
    lit = group(
        [[0, 0, 0], [0.5, 0, 0]],
        velocities=[[value, 0, 0], [1, 0, 0]],
        temperatures=broken,
        ages=broken,
        lifetimes=broken,
    )
    for style in (
        {"color": "blackbody"},
        {"as": "dots", "color": {"by": "speed", "map": "ice", "range": [0, 2]}},
        {"as": "streaks", "color": {"by": "age", "map": "ice"}, "fade_out": 0.5},
    ):
        assert np.isfinite(Renderer(scene(dust=style)).light(frame(dust=lit))).all()


def test_particles_fade_in_and_out_over_their_life() -> None:
    renderer = Renderer(scene(dust={"fade_in": 0.2, "fade_out": 0.5}))
    shares = [0, 0.1, 0.2, 0.5, 0.75, 1]
    seen = [renderer.light(frame(dust=group([[0, 0, 0]], ages=[2 * share], lifetimes=[2]))).sum() for share in shares]
    assert np.array(seen) / seen[2] == pytest.approx([0, 0.5, 1, 1, 0.5, 0], abs=0.01)
    immortal = renderer.light(frame(dust=group([[0, 0, 0]], ages=[1]))).sum()
    assert immortal == pytest.approx(seen[2])


def test_batches_draw_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    renderer = Renderer(scene(bloom=0.1, planes=[{}], dust={"color": {"by": "id", "map": "turbo", "range": [0, 500]}}))
    whole = renderer.light(frame(dust=dust()))
    monkeypatch.setattr(particles, "MANY", 77)
    assert renderer.light(frame(dust=dust())) == pytest.approx(whole, rel=1e-3, abs=1e-5)


@pytest.mark.parametrize("look", ["glow", "streaks", "dots"])
def test_sprites_without_room_for_their_records_are_drawn_in_parts(look: str, monkeypatch: pytest.MonkeyPatch) -> None:
    renderer = Renderer(scene(planes=[{}], dust={"as": look, "pixels": 5}))
    lit = frame(dust=dust(velocities=3 * PLACES, ages=PLACES[:, 0] + 2))
    whole = renderer.light(lit)
    monkeypatch.setattr(store_for(0), "room", 300)
    assert renderer.light(lit) == pytest.approx(whole, rel=1e-3, abs=1e-5)


def test_double_precision_frames_draw_the_same_also_far_from_the_origin() -> None:
    far = np.array([1e7, -2e7, 3e7])
    camera = {"position": (far + np.array([0, 0, 4])).tolist(), "look_at": far.tolist(), "field_of_view": 40}
    here = Renderer(scene()).light(frame(dust=dust()))
    there = Renderer(scene(camera=camera)).light(frame(dust=group(PLACES + far, dtype=np.float64)))
    assert there == pytest.approx(here, rel=1e-3, abs=1e-4)


def test_frames_follow_each_other_without_a_trace() -> None:
    renderer = Renderer(scene(bloom=0.2, planes=[{}]))
    first = renderer.render(frame(dust=dust())).copy()
    renderer.render(frame(dust=group(np.zeros((0, 3)))))
    assert np.array_equal(renderer.render(frame(dust=dust())), first)


def test_renderers_of_other_sizes_leave_no_trace_in_each_other() -> None:
    """They share the room for light."""
    style = {"pixels": 40}
    lit = frame(dust=group(3 * PLACES))
    one = Renderer(scene(bloom=0.2, planes=[{}], dust=style))
    first = one.light(lit)
    Renderer(scene(size=(91, 70), bloom=0.5, dust=style)).light(lit)
    assert np.array_equal(one.light(lit), first)


@pytest.mark.slow
def test_double_precision_kernels_paint_the_same_picture() -> None:
    style = {"as": "streaks", "pixels": 6, "color": "blackbody"}
    lit = frame(dust=dust(velocities=PLACES, ages=PLACES[:, 0] + 2, temperatures=1500 + 100 * PLACES[:, 0]))
    spec = scene(planes=[{"point": [0, -1, 0]}], bloom=0.1, dust=style)
    single = Renderer(spec).render(lit).astype(int)
    runtime.start("double", 2)
    double = Renderer(spec).render(lit).astype(int)
    assert np.abs(double - single).max() <= 1
    assert (double != single).mean() < 0.01

"""The scenes that are shipped: each loads, says all it should, and shows something."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from particlecli.frame import Frame, GroupFrame
from particlecli.render.renderer import Renderer
from particlecli.scene.load import load_scene
from particlecli.simulate import Simulation

SCENES = sorted((Path(__file__).parents[1] / "scenes").glob("*.yaml"))
WIDTH, HEIGHT = 64, 36

BRIEFLY = ("integrator.type=euler", "integrator.contact=end_of_step")
"""Compiles in a fraction of the time, and is stable at the scenes' steps, but for springs."""

AT_ONCE = {"autumn", "dam_break", "fish_school", "flag", "gas", "hair", "jelly"}
"""Scenes that keep their scheme, and that show all they have from the beginning."""

SLOWLY = {"sand", "snake"}
"""Scenes of particles that act on each other, which keep their scheme too."""


@pytest.fixture(params=SCENES, ids=lambda path: path.stem)
def path(request: pytest.FixtureRequest) -> Path:
    found: Path = request.param
    return found


def test_there_are_scenes_to_look_at() -> None:
    assert {"campfire", "fountain", "snow", "smoke", "fireworks", "million_sparks"} <= {path.stem for path in SCENES}


def test_scene_says_what_it_shows_and_where_it_goes(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    scene = load_scene(path)
    assert text.startswith("# ")
    assert scene.title
    assert 6 <= scene.duration <= 10
    assert (scene.fps, scene.camera.resolution) == (30, (1280, 720))
    assert scene.look.groups.keys() == scene.groups.keys()
    assert [(output.type, output.path) for output in scene.outputs] == [("video", f"{path.stem}.mp4")]


def test_its_beginning_shows_something(path: Path) -> None:
    seconds = "duration=0.04" if path.stem in AT_ONCE else "duration=1"
    scene = load_scene(path, [seconds, *(() if path.stem in AT_ONCE | SLOWLY else BRIEFLY)])
    simulation = Simulation(scene, threads=2)
    renderer = Renderer(scene, WIDTH, HEIGHT)
    for frame in simulation:
        if frame.index in (0, 1, scene.frame_count - 1):
            picture = renderer.render(frame).astype(int)
    nothing = renderer.render(_emptied(frame)).astype(int)
    shown = (picture - nothing).max(axis=-1)
    assert shown.max() > 50
    assert (shown > 4).mean() > 0.02
    assert (picture.min(axis=-1) == 255).mean() < 0.01


def _emptied(frame: Frame) -> Frame:
    return replace(frame, groups={name: _none_of(group) for name, group in frame.groups.items()})


def _none_of(group: GroupFrame) -> GroupFrame:
    emptied: dict[str, Any] = {name: None if values is None else values[:0] for name, values in vars(group).items()}
    return replace(group, **emptied)

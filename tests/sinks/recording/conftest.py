"""A scene and its frames, and the recording of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from particlecli.frame import Curve, Frame, GroupFrame
from particlecli.scene.load import load_scene
from particlecli.scene.model import Scene
from particlecli.sinks.recording.sink import RecordingSink

SCENE = """\
title: Two groups
duration: 0.1
fps: 30
frames:
  base: {rotate: {axis: [0, 1, 0], angle: "30*t"}}
  tip: {parent: base, translate: [1, "30*t", 0], scale: 2}
particles:
  dust: {file: dust.csv}
emitters:
  sparks: {rate: 10, lifetime: 2}
planes: [{normal: [0, 3, 4]}, {normal: [1, 0, 0], point: [0.5, 0, 0], frame: tip}]
look:
  groups:
    dust: {color: "#ff0000", radius: 0.5}
    sparks: {as: hidden, pixels: 3, color: {by: age, map: ["#000000", "#ffffff"]}}
"""

Record = Callable[..., Path]


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    folder = tmp_path / "scenes"
    folder.mkdir()
    (folder / "dust.csv").write_text("x,y,z\n" + "0,0,0\n" * 100)
    (folder / "two.yaml").write_text(SCENE)
    return load_scene(folder / "two.yaml")


@pytest.fixture
def frames() -> list[Frame]:
    """Four frames: a group that stays at a hundred, and one of which one is born and one dies each frame."""
    rng = np.random.default_rng(1)
    made = []
    for index in range(4):
        dust = GroupFrame(np.arange(100), rng.normal(size=(100, 3)).astype(np.float32))
        ages = np.array([0.0, 1.0, 2.0])
        sparks = GroupFrame(np.arange(index, index + 3), rng.normal(size=(3, 3)), ages=ages, lifetimes=np.full(3, 2.0))
        series = {"energy": {"kinetic": index / 3}, "deaths": {"sparks/expired": float(index)}}
        springs = {"sparks": np.array([[2, 3], [1, 2]])}  # of which only some ends live
        made.append(Frame(index, index / 30, {"dust": dust, "sparks": sparks}, series, springs))
    return made


@pytest.fixture
def record(tmp_path: Path, scene: Scene) -> Record:
    """Makes a recording of frames."""

    def make(name: str, frames: Sequence[Frame], every: int = 1, max_points: int | None = None) -> Path:
        path = tmp_path / name
        sink = RecordingSink(path, scene, every=every, max_points=max_points)
        sink.open()
        for frame in frames:
            sink.write(frame, None)
            assert not path.exists()
        sink.conclude('{"frames": 4}', {"dust": Curve((1, 3), (1 / 30, 0.1), (1e-6, 3e-6))})
        sink.close()
        assert sink.files == (path,)
        return path

    return make

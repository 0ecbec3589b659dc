"""A recording of 100,000 points over 300 frames: how fast it is written, and how soon it is inspected."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from particlecli.frame import Frame, GroupFrame
from particlecli.scene.model import Scene
from particlecli.sinks.recording.sink import RecordingSink
from tests.benchmarks.figures import Figure
from tests.benchmarks.processes import fastest

POINTS = 100_000
FRAMES = 300
SLOWEST = 20.0
"""Million points a second."""

LONGEST = 2.0
"""s."""

GOES = 3

SCENE = {
    "duration": (FRAMES - 1) / 30,
    "fps": 30,
    "particles": {"dust": {"positions": [[0, 0, 0]]}},
    "look": {"groups": {"dust": {"color": "#ffffff"}}},
}
SPEED = {"by": "speed", "map": "viridis", "range": [0, 2]}


def measure() -> list[Figure]:
    """Points a second with one colour for all and with one for each, and seconds of a whole `inspect`."""
    plain = Scene.model_validate(SCENE)
    colored = Scene.model_validate({**SCENE, "look": {"groups": {"dust": {"color": SPEED}}}})
    frames = _frames()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "dust.rrd"
        paces = {name: _pace(scene, frames, path) for name, scene in (("colored", colored), ("plain", plain))}
        seconds = fastest({"inspect": ["-m", "particlecli", "inspect", str(path)]}, GOES)["inspect"]
    return [
        Figure("recording points of one colour", paces["plain"], "M points/s", "more", must=SLOWEST),
        Figure("recording points coloured by speed", paces["colored"], "M points/s", "more", must=SLOWEST),
        Figure(f"inspecting {POINTS:,} points × {FRAMES} frames", seconds, "s", "less", must=LONGEST),
    ]


def _frames() -> list[Frame]:
    """A second of noise, which does not compress."""
    rng = np.random.default_rng(0)
    ids = np.arange(POINTS)
    return [
        Frame(index, index / 30, {"dust": GroupFrame(ids, _vectors(rng), velocities=_vectors(rng))}, {})
        for index in range(30)
    ]


def _vectors(rng: np.random.Generator) -> np.ndarray:
    return rng.normal(size=(3, POINTS)).astype(np.float32).T


def _pace(scene: Scene, frames: list[Frame], path: Path) -> float:
    paces = []
    for _ in range(GOES):
        sink = RecordingSink(path, scene)
        began = time.perf_counter()
        sink.open()
        for index in range(FRAMES):
            frame = frames[index % len(frames)]
            sink.write(Frame(index, index / 30, frame.groups), None)
        sink.conclude('{"frames": 300, "alive": 100000, "phases": {"wall_s": 1}}', {})
        sink.close()
        paces.append(POINTS * FRAMES / (time.perf_counter() - began) / 1e6)
    return max(paces)

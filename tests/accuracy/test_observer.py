from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from particlecli.accuracy.observer import Observer
from particlecli.frame import Frame
from particlecli.scene.model import Scene
from particlecli.simulate import Simulation

SCENE = {
    "duration": 0.5,
    "fps": 10,
    "precision": "double",
    "particles": {
        "balls": {
            "positions": [[0, 1, 0], [0, 2, 0]],
            "velocities": [[1, 0, 0], [0, 0, -2]],
            "masses": [1, 3],
        },
    },
    "emitters": {"sparks": {"bursts": [{"time": 0, "count": 5}], "lifetime": 0.25}},
    "forces": [{"type": "gravity", "acceleration": [0, -10, 0], "on": ["balls"]}],
    "integrator": {"type": "velocity_verlet", "dt": 0.05},
}

FIELDS = {"balls": frozenset({"velocities"}), "sparks": frozenset({"velocities"})}


@pytest.fixture(scope="module")
def frames() -> list[Frame]:
    simulation = Simulation(Scene.model_validate(SCENE), fields=FIELDS)
    observer = Observer(simulation)
    return [replace(frame, series=observer.series(frame)) for frame in simulation]


def test_springs_are_there_until_they_break() -> None:
    pairs = [[0, 1], [2, 1], [17, 3]]
    scene = {
        "duration": 0.2,
        "fps": 10,
        "particles": {
            "nodes": {"positions": [[i, 0, 0] for i in range(18)], "velocities": [[0, 0, 0]] * 17 + [[90, 0, 0]]}
        },
        "forces": [{"type": "springs", "pairs": pairs, "stiffness": 1, "breaks_at": 0.5}],
        "integrator": {"type": "symplectic_euler", "dt": 0.05},
    }
    simulation = Simulation(Scene.model_validate(scene))
    observer = Observer(simulation)
    whole = [{frozenset(pair) for pair in observer.springs()["nodes"].tolist()} for _ in simulation]
    assert whole[0] == {frozenset(pair) for pair in pairs}
    assert whole[-1] == {frozenset(pair) for pair in pairs[:2]}


def test_counts(frames: list[Frame]) -> None:
    assert [frame.series["alive"]["sparks"] for frame in frames] == [5, 5, 5, 0, 0, 0]
    assert frames[2].series["deaths"] == {}
    assert frames[-1].series["deaths"] == {"sparks/expired": 5}


def test_energy_is_that_of_a_fall(frames: list[Frame]) -> None:
    for frame in frames:
        balls = frame.groups["balls"]
        mass = np.array([1, 3])
        kinetic = 0.5 * mass @ (balls.velocities**2).sum(axis=1)
        assert frame.series["energy"]["kinetic"] == pytest.approx(kinetic, rel=1e-12)
        assert frame.series["energy"]["potential"] == pytest.approx(10 * mass @ balls.positions[:, 1], rel=1e-12)
        assert frame.series["energy"]["total"] == pytest.approx(0.5 + 6 + 10 + 60, rel=1e-12)


def test_momentum_is_that_of_a_fall(frames: list[Frame]) -> None:
    for frame in frames:
        momentum = frame.series["momentum"]
        assert [momentum[axis] for axis in "xyz"] == pytest.approx([1, -40 * frame.time, -6], abs=1e-12)

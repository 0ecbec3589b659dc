"""The estimated error of a run: near the true one, honest where there is none to be had, and without a trace."""

from __future__ import annotations

import numpy as np
import pytest

from particlecli.accuracy.samples import COARSER, Sample
from particlecli.dynamics.rerun import Stretch, rerun
from particlecli.scene.load import load_scene
from tests.accuracy.estimating import CALIBRATION, MORE, PROBLEMS, WITHIN, estimated, true_size, truth, view_of
from tests.cases import later
from tests.dynamics.scenes import body, scene


@pytest.mark.parametrize(("name", "change"), [*CALIBRATION, *later(*MORE)])
def test_estimates_are_near_the_true_error_on_reference_problems(name, change):
    described = load_scene(PROBLEMS / f"{name}.yaml", [change])
    tracks = truth(described)
    errors, frames, _ = estimated(described)
    assert errors
    for group, error in errors.items():
        assert error.trend in ("converging", "irregular")
        true = true_size(frames, tracks, group)
        assert true / WITHIN < error.metres.p95 < WITHIN * true


SPARKS = {
    "duration": 2,
    "fps": 10,
    "seed": 3,
    "emitters": {
        "sparks": {
            "rate": 400,
            "speed": {"uniform": [2, 6]},
            "direction": {"spread": 50},
            "mass": {"uniform": [0.5, 2]},
            "lifetime": {"uniform": [0.3, 0.9]},
        }
    },
    "flows": {"wind": [{"type": "vortex", "circulation": 9, "core": 0.5}]},
    "forces": [{"type": "gravity"}, {"type": "drag", "coefficient": 2, "flow": "wind"}],
    "planes": [{"normal": [0, 1, 0], "restitution": 0.5, "friction": 0.2}],
    "integrator": {"type": "midpoint", "dt": 0.05},
    "camera": {"position": [0, 1, 8], "look_at": [0, 1, 0], "resolution": [640, 360]},
}


def test_a_sample_stands_for_all_particles_in_metres_and_pixels():
    described = scene(**SPARKS)
    tracks = truth(described)
    errors, frames, _ = estimated(described)
    error = errors["sparks"]
    true = true_size(frames, tracks, "sparks")
    assert error.trend == "converging"
    assert error.sampled < 100 < len(tracks["sparks"].ids)
    assert true / WITHIN < error.metres.p95 < WITHIN * true
    assert error.metres.largest >= error.metres.p95
    pixel = 8 / view_of(described).focal
    assert error.pixels is not None
    assert 0.5 < error.pixels.p95 * pixel / error.metres.p95 < 2.0
    assert error.alone < 0.05
    assert error.over_time.times == tuple(frame / described.fps for frame in error.over_time.frames)
    for index, value in zip(error.over_time.frames, error.over_time.values, strict=True):
        true = true_size([frames[0], frames[index]], tracks, "sparks")
        assert true / WITHIN < value < WITHIN * true


def test_estimating_leaves_no_trace_and_reruns_give_the_same():
    errors, frames, simulation = estimated(scene(**SPARKS))
    again = simulation.system.frame(len(frames) - 1)
    for name, group in again.groups.items():
        np.testing.assert_array_equal(group.positions, frames[-1].groups[name].positions)
        np.testing.assert_array_equal(group.ids, frames[-1].groups[name].ids)
        np.testing.assert_array_equal(group.ages, frames[-1].groups[name].ages)
    _rerun_gives_the_same_positions(frames, simulation)
    other, _, _ = estimated(scene(**SPARKS), threads=2)
    assert other == errors


def _rerun_gives_the_same_positions(frames, simulation):
    group = simulation.system.groups["sparks"]
    ids = np.arange(5, 60, 4)
    stretches = [Stretch(frame.time, simulation.plan.steps_per_frame) for frame in frames[1:]]
    found = rerun(group, group.plan.births.of(ids), stretches)
    for index, frame in enumerate(frames[1:]):
        there = frame.groups["sparks"]
        both = np.intersect1d(ids, there.ids)
        alive = ~np.isnan(found.positions[index, :, 0])
        np.testing.assert_array_equal(ids[alive], both)
        np.testing.assert_array_equal(
            found.positions[index, alive], there.positions[np.searchsorted(there.ids, both)].astype(np.float64)
        )


def test_a_rerun_of_all_that_act_on_each_other_leaves_no_trace():
    described = load_scene(PROBLEMS / "figure_eight.yaml", ["integrator={type: rk4, dt: 0.02}"])
    errors, frames, simulation = estimated(described)
    assert errors["stars"].trend == "converging"
    system = simulation.system
    assert (system.time, system.births, system.particle_steps > 0) == (frames[-1].time, {"stars": 3}, True)
    again = system.frame(len(frames) - 1).groups["stars"]
    np.testing.assert_array_equal(again.positions, frames[-1].groups["stars"].positions)
    np.testing.assert_array_equal(again.velocities, frames[-1].groups["stars"].velocities)


def test_chaos_is_called_chaos(monkeypatch):
    waves = [{"type": "abc", "amplitudes": [1.7, 1.4, 1]}]
    dust = {"dust": {"motion": "first_order", "flow": "waves", "layout": GRID}}
    carried = {"fps": 1, "flows": {"waves": waves}, "particles": dust, "integrator": {"type": "midpoint", "dt": 0.25}}
    for duration, trend in ((80, "chaotic"), (4, "converging")):
        errors, _, _ = estimated(scene(**{**carried, "duration": duration}))
        assert errors["dust"].trend == trend
    monkeypatch.setattr(Sample, "comparisons", lambda _: [COARSER])
    errors, _, _ = estimated(scene(**{**carried, "duration": 80}))
    assert errors["dust"].trend == "unsettled"


GRID = {"type": "grid", "spacing": 0.7, "counts": [4, 4, 4]}


@pytest.mark.parametrize("precision", ["single", "double"])
def test_steps_lost_in_the_rounding_of_large_coordinates_are_told(precision):
    far = {"far": body((1e6, 0, 0), (4, 0, 0))}
    errors, frames, _ = estimated(
        scene(
            duration=4,
            precision=precision,
            particles=far,
            forces=[{"type": "gravity"}],
            integrator={"type": "rk4", "dt": 0.005},
        )
    )
    true = abs(frames[-1].groups["far"].positions[0, 0] - (1e6 + 16))
    error = errors["far"].metres.p95
    if precision == "single":
        assert true > 1
        assert true / WITHIN < error < WITHIN * true
        assert errors["far"].trend == "rounding"
    else:
        assert error < 1e-6


def test_particles_alive_in_one_solution_alone_are_counted():
    errors, _, _ = estimated(
        scene(
            duration=3,
            flows={"out": [{"type": "expression", "velocity": ["1 + x", "0", "0"]}]},
            emitters={
                "dust": {
                    "motion": "first_order",
                    "flow": "out",
                    "rate": 100,
                    "dies": {"outside": {"min": [-1, -1, -1], "max": [3, 1, 1]}},
                }
            },
            integrator={"type": "euler", "dt": 0.1},
        )
    )
    assert 0.01 < errors["dust"].alone < 0.3


def test_nothing_acts_nothing_errs_but_the_last_digit():
    errors, _, _ = estimated(scene(particles={"stones": body((3, 0, 0), (1, 0, 0))}))
    assert errors["stones"].trend == "rounding"
    assert 0 < errors["stones"].metres.largest < 1e-6


def test_there_is_nothing_to_estimate_in_a_single_frame():
    assert estimated(scene(duration=0.01, particles={"stones": body((3, 0, 0), (1, 0, 0))}))[0] == {}

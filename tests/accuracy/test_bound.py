"""Estimates that may not cost much: from longer steps, or none at all, and then the groups are named."""

from __future__ import annotations

import pytest

from particlecli.accuracy import bound
from particlecli.accuracy.bound import Together
from particlecli.accuracy.estimate import ErrorEstimate
from particlecli.accuracy.prices import Besides
from particlecli.accuracy.samples import COARSER, FINER, Sample
from particlecli.scene.load import load_scene
from particlecli.simulate import Simulation
from tests.accuracy.estimating import CALIBRATION, MORE, PROBLEMS, WITHIN, estimated, true_size, truth, view_of
from tests.cases import later
from tests.dynamics.scenes import scene

NOTHING_ELSE = Besides(0.0)
"""Of a run that makes neither pictures nor records."""


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("kepler", "integrator={type: rk4, dt: 0.001}"),
        *later(
            ("figure_eight", "integrator={type: rk4, dt: 0.002}"),
            ("figure_eight", "integrator={type: velocity_verlet, dt: 0.0011}"),
        ),
    ],
)
def test_what_little_pays_for_is_compared_with_longer_steps(name, change):
    described = load_scene(PROBLEMS / f"{name}.yaml", [change])
    tracks = truth(described)
    errors, frames, _ = estimated(described, besides=NOTHING_ELSE)
    (group, error), *_ = errors.items()
    true = true_size(frames, tracks, group)
    assert error.trend == "converging"
    assert true / WITHIN < error.metres.p95 < WITHIN * true
    finer, _, _ = estimated(described)
    assert finer[group] != error


BOUNCES = ("bouncing_ball", "integrator.contact=end_of_step")
"""Where it bounces leaps from step to step: no longer step tells what a shorter one does."""


@pytest.mark.parametrize(("name", "change"), later(*CALIBRATION, *MORE))
def test_longer_steps_are_near_the_true_error_as_well(name, change, monkeypatch):
    monkeypatch.setattr(Sample, "comparisons", lambda sample: [FINER if sample.group.plan.adaptive else COARSER])
    monkeypatch.setattr(Together, "comparisons", lambda _: [COARSER])
    described = load_scene(PROBLEMS / f"{name}.yaml", [change])
    tracks = truth(described)
    errors, frames, _ = estimated(described)
    for group, error in errors.items():
        if (name, change) == BOUNCES:
            assert error.trend == "unsettled"
            continue
        true = true_size(frames, tracks, group)
        assert error.trend in ("converging", "irregular")
        assert true / WITHIN < error.metres.p95 < WITHIN * true


@pytest.mark.slow
def test_longer_steps_that_blow_up_tell_nothing(monkeypatch):
    monkeypatch.setattr(Together, "comparisons", lambda _: [COARSER])
    stiff = {"a": {"positions": [[0, 0, 0], [1.01, 0, 0]]}}
    springs = [{"type": "springs", "stiffness": 5e3, "pairs": [[0, 1]], "rest_length": "1"}]
    described = scene(
        duration=10, fps=10, particles=stiff, forces=springs, integrator={"type": "velocity_verlet", "dt": 0.0125}
    )
    assert unpaid(described, Besides()) == ({}, ("a",))


def unpaid(described, besides):
    """The estimate of a run, and which groups it leaves out."""
    simulation = Simulation(described, threads=1)
    estimate = ErrorEstimate(simulation, lambda _: view_of(described), besides)
    for frame in simulation:
        estimate.watch(frame)
    return estimate.result(), estimate.left_out


def test_what_cannot_be_paid_for_is_left_out_and_named():
    described = load_scene(PROBLEMS / "kepler.yaml", ["integrator={type: rk4, dt: 0.0001}"])
    assert unpaid(described, NOTHING_ELSE) == ({}, ("planet",))


def test_too_many_together_are_named(monkeypatch):
    monkeypatch.setattr(bound, "MOST_TOGETHER", 2)
    described = load_scene(PROBLEMS / "figure_eight.yaml")
    assert unpaid(described, Besides()) == ({}, ("stars",))


def test_an_adaptive_scheme_that_takes_more_than_foreseen_is_stopped():
    described = load_scene(PROBLEMS / "spring_pendulum_1e6.yaml", [])
    assert unpaid(described, Besides(2.5)) == ({}, ("bob",))

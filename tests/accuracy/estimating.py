"""Runs with an estimate of their error, and how large it truly is."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from particlecli.accuracy.estimate import ErrorEstimate
from particlecli.accuracy.trial import Pace, Trial, trial_plan
from particlecli.render.camera import View
from particlecli.runtime import start
from particlecli.simulate import Simulation

PROBLEMS = Path(__file__).parents[2] / "scenes" / "reference"
WITHIN = 3.0
"""The factor within which an estimate is to be right."""


def view_of(described):
    return View.of(described.camera, *described.camera.resolution)


def estimated(described, threads=1, besides=None):
    """The estimate of a run, and its record of all particles at all frames."""
    simulation = Simulation(described, threads=threads)
    estimate = ErrorEstimate(simulation, lambda _: view_of(described), besides)
    frames = []
    for frame in simulation:
        estimate.watch(frame)
        frames.append(frame)
    return estimate.result(), frames, simulation


def truth(described):
    """Where all particles are at all frames, as well as double precision tells."""
    located = described.integrator.model_copy(update={"contact": "located"})
    start("double", 1)
    plan = trial_plan(described.model_copy(update={"integrator": located}), "dop853", "double", 10**6)
    ids = {group.name: np.arange(group.births.total) for group in plan.groups}
    return Trial(plan, ids, measures_energy=False).run(Pace(tolerance=1e-13)).tracks


def true_size(frames, tracks, name):
    """The 95th percentile over particles and frames."""
    apart = []
    for frame in frames[1:]:
        group = frame.groups[name]
        apart.append(np.linalg.norm(group.positions - tracks[name].positions[frame.index, group.ids], axis=1))
    together = np.concatenate(apart)
    return np.quantile(together[~np.isnan(together)], 0.95)


CALIBRATION = [
    # a problem, how it is integrated
    ("kepler", "integrator={type: rk4, dt: 0.002}"),
    ("bouncing_ball", "integrator.contact=end_of_step"),
]

MORE = [
    ("figure_eight", "integrator={type: velocity_verlet, dt: 0.002}"),
    ("kepler", "integrator={type: velocity_verlet, dt: 0.0005}"),
    ("linear_drag", "integrator.type=euler"),
    ("kepler", "integrator={type: dormand_prince, tolerance: 1e-6}"),
    ("double_gyre", "integrator={type: rk3, dt: 0.1}"),
    ("flat_slide", "integrator.contact=end_of_step"),
    ("damped_oscillator", "integrator={type: trapezoidal, dt: 0.01}"),
    ("henon_heiles", "integrator={type: yoshida4, dt: 0.1}"),
    ("arenstorf", "integrator.tolerance=1e-9"),
    ("abc_flow", "integrator.type=midpoint"),
    ("spring_pendulum_1e4", "integrator={type: implicit_midpoint, dt: 0.01}"),
    ("quadratic_drag", "integrator={type: rk4, dt: 0.02}"),
]

"""Runs against known answers: how errors are measured, and the shipped problems with the twins that must fail."""

import math
from pathlib import Path

import pytest

from particlecli.accuracy.references import Comparison, compare_with_known
from particlecli.scene.load import load_scene
from tests.dynamics.scenes import body, scene

PROBLEMS = Path(__file__).parents[2] / "scenes" / "reference"
LONG = {"incline", "catenary", "dam_break", "hydrostatic_tank", "taylor_green"}
"""Problems of very many steps, or of very many equations in each."""

TWINS = [
    # a problem, and what is changed in it
    ("abc_flow", "flows.waves.0.amplitudes=[0.816496580927726, 1, 0.5773502691896257]"),
    ("abc_flow", "integrator.type=rk3"),
    ("arenstorf", "particles.satellite.velocities=[[0, -2.0015851, 0]]"),
    ("arenstorf", "integrator.tolerance=1e-9"),
    ("bouncing_ball", "planes.0.restitution=0.4999999"),
    ("bouncing_ball", "integrator.contact=end_of_step"),
    ("catenary", "forces.1.stiffness=2e4"),
    ("damped_oscillator", "forces.2.coefficient=10"),
    ("damped_oscillator", "integrator.type=midpoint"),
    ("dam_break", "forces.0.acceleration=[0, -7.5, 0]"),
    ("double_gyre", "flows.gyres.0.swing=0.125"),
    ("double_gyre", "flows.gyres.0.amplitude=-0.1"),
    ("elliptical_drop", "particles.drop.velocity=['-97*x', '97*y', 0]"),
    ("figure_eight", "forces.0.softening=1e-3"),
    ("figure_eight", "integrator={type: rk4, dt: 0.01}"),
    ("flat_slide", "planes.0.friction=0.2999999"),
    ("flat_slide", "integrator.contact=end_of_step"),
    ("henon_heiles", "forces.0.potential=(x**2 + y**2)/2 - x**2*y - y**3/3"),
    ("henon_heiles", "integrator={type: rk4, dt: 0.01}"),
    ("hydrostatic_tank", "forces.0.acceleration=[0, -9.5, 0]"),
    ("incline", "planes.0.friction=0.1"),
    ("incline", "planes.1.friction=0.57"),
    ("kepler", "forces.0.strength=0.5"),
    ("kepler", "integrator={type: rk4, dt: 0.002}"),
    ("linear_drag", "forces.1.coefficient=0.25"),
    ("linear_drag", "integrator.type=rk3"),
    ("pleiades", "forces.0.strength=0.999"),
    ("pleiades", "integrator={type: velocity_verlet, dt: 0.001}"),
    ("quadratic_drag", "forces.1.coefficient=0.05"),
    ("quadratic_drag", "integrator={type: midpoint, dt: 0.01}"),
    ("radial_fall", "forces.0.strength=-1"),
    ("radial_fall", "forces.0.softening=1e-4"),
    ("spring_pendulum_1e4", "forces.0.potential=5e3/2*(sqrt(x**2 + y**2) - 1)**2 + y"),
    ("spring_pendulum_1e4", "integrator.tolerance=1e-7"),
    ("spring_pendulum_1e6", "forces.0.potential=1e6/2*(sqrt(x**2 + y**2) - 1)**2 - y"),
    ("taylor_green", "forces.0.viscosity.laminar=0.0095"),
]

BRIEF = {"bouncing_ball", "kepler", "linear_drag"}
"""Problems whose twins are run by default."""


def slow_if_long(name):
    return pytest.param(name, marks=[pytest.mark.slow] if name in LONG else [])


@pytest.mark.parametrize("name", [slow_if_long(path.stem) for path in sorted(PROBLEMS.glob("*.yaml"))])
def test_shipped_problems_are_solved_within_their_tolerances(name):
    comparisons = compare_with_known(load_scene(PROBLEMS / f"{name}.yaml"))
    assert comparisons
    assert [each for each in comparisons if not each.passed] == []


@pytest.mark.parametrize(
    ("name", "change"), [pytest.param(*twin, marks=[] if twin[0] in BRIEF else [pytest.mark.slow]) for twin in TWINS]
)
def test_a_problem_with_one_thing_wrong_fails(name, change):
    assert not all(each.passed for each in compare_with_known(load_scene(PROBLEMS / f"{name}.yaml", [change])))


def test_every_shipped_problem_has_a_twin():
    assert {name for name, _ in TWINS} == {path.stem for path in PROBLEMS.glob("*.yaml")}


FALL = {
    "precision": "double",
    "particles": {
        "a": {
            "positions": [[0, 0, 0], [0, 5, 0], [3, 4, 0]],
            "velocities": [[1, 0, 0], [0, 2, 0], [0, 0, 0]],
            "masses": [1, 2, 4],
        }
    },
    "forces": [{"type": "gravity", "acceleration": [0, -10, 0]}],
}


def compared(*answers, **parts) -> list[Comparison]:
    known = [{"at": 1, "group": "a", "tolerance": 1e-9, **answer} for answer in answers]
    return compare_with_known(scene(**{**FALL, **parts}, reference=known))


def test_all_particles_or_chosen_ones_in_any_order():
    right = [[1, -5, 0], [0, 2, 0], [3, -1, 0]]
    everyone, two, one = compared(
        {"positions": right},
        {"particles": [2, 0], "positions": [right[2], right[0]]},
        {"particles": [1], "velocity": [0, -8, 0]},
    )
    assert everyone.passed
    assert two.passed
    assert one.passed
    assert (one.particle, one.quantity, one.unit) == (1, "velocity", "m/s")


def test_the_error_is_that_of_the_particle_furthest_off():
    (found,) = compared({"positions": [[1, -5, 0.1], [0, 2.3, 0.4], [3, -1, 0.2]], "tolerance": 0.4})
    assert found.error == pytest.approx(0.5)
    assert not found.passed
    assert (found.particle, found.expected, found.found) == (1, (0, 2.3, 0.4), pytest.approx((0, 2, 0)))


def test_relative_errors_are_parts_of_the_known_value():
    answer = {"particles": [1], "velocity": [0, -10, 0]}
    wide, narrow = compared({**answer, "tolerance": {"relative": 0.21}}, {**answer, "tolerance": {"relative": 0.19}})
    assert wide.error == narrow.error == pytest.approx(0.2)
    assert wide.relative
    assert wide.passed
    assert not narrow.passed


def test_energy_is_that_of_all_together_and_quantities_that_of_each():
    energy, share, distance, rotation = compared(
        {"energy": 1 / 2 + 4 + 2 * 50 + 4 * 40},
        {"particles": [1], "energy": 4 + 2 * 50},
        {"particles": [2], "quantity": "distance + speed*t", "value": 15},
        {"particles": [0], "quantity": "x*v - y*u", "value": -5},
    )
    assert energy.passed
    assert energy.particle is None
    assert share.passed
    assert distance.passed
    assert rotation.passed
    assert not compared({"energy": 1 / 2 + 4 + 2 * 50 + 4 * 20})[0].passed


def test_statistics_are_of_all_that_are_meant():
    heights = [-5, 2, -1]
    known = {"min": -5, "max": 2, "mean": -4 / 3, "rms": 10**0.5, "sum": -4}
    low = {"min": -5, "max": -1, "mean": -3, "rms": 13**0.5, "sum": -6}
    found = compared(
        *({"quantity": "y", "of_all": of_all, "value": value} for of_all, value in known.items()),
        *({"where": "y < 0", "quantity": "y", "of_all": of_all, "value": value} for of_all, value in low.items()),
        {"particles": [1, 2], "where": "speed", "quantity": "y", "of_all": "max", "value": max(heights)},
        {"where": "-y", "positions": [[1, -5, 0], [3, -1, 0]]},
    )
    assert [each for each in found if not each.passed] == []
    assert (found[0].quantity, found[0].particle) == ("min of y", None)
    wrong, nobody, many = compared(
        {"quantity": "y", "of_all": "mean", "value": 1},
        {"where": "y > 9", "quantity": "y", "of_all": "mean", "value": 1},
        {"where": "y < 0", "positions": [[1, -5, 0]]},
    )
    assert wrong.error == pytest.approx(7 / 3)
    assert nobody.trouble == "there is no particle where y > 9"
    assert many.trouble == "2 particles are there, 1 are known"


def test_energy_of_masses_that_differ_in_a_field_of_force():
    field = {"type": "force_field", "potential": "7*y"}
    (found,) = compared({"at": 0, "energy": 1 / 2 + 4 + 7 * 9}, forces=[field, {"type": "drag", "coefficient": 1}])
    assert found.passed


def test_times_between_frames_and_answers_out_of_order():
    late, early = compared(
        {"at": 0.777, "particles": [1], "position": [0, 5 + 2 * 0.777 - 5 * 0.777**2, 0]},
        {"at": 1e-4, "particles": [0], "velocity": [1, -1e-3, 0]},
    )
    assert late.at > early.at
    assert late.passed
    assert early.passed


def test_particles_that_are_not_there_fail_with_a_reason():
    mortal = {"a": {**body((0, 0, 0), (0, 0, 0)), "lifetime": 0.5}}
    dead, none, count = compared(
        {"particles": [0], "position": [0, 0, 0]},
        {"quantity": "x", "value": 0},
        {"at": 0.25, "group": "b", "positions": [[0, 0, 0]] * 4},
        particles=mortal,
        emitters={"b": {"bursts": [{"time": 0, "count": 3}]}},
    )
    assert (dead.trouble, none.trouble) == ("particle 0 is not alive", "no particle is alive")
    assert count.trouble == "3 particles are alive, 4 are known"
    for each in (dead, none, count):
        assert not each.passed
        assert each.error == math.inf


def test_particles_born_later_count_from_their_birth():
    emitter = {"rate": 10, "speed": 3.0, "direction": {"axis": [1, 0, 0]}}
    (found,) = compared(
        {"group": "b", "particles": [3], "quantity": "distance", "value": 3 * 0.65},
        emitters={"b": emitter},
        forces=[],
    )
    assert found.passed


def test_a_run_in_single_precision_is_judged_as_it_is():
    (found,) = compared(
        {"particles": [1], "position": [0, 5 + 2 / 3 - 5 / 9, 0], "at": 1 / 3, "tolerance": 1e-5},
        precision="single",
    )
    assert found.passed
    assert 1e-9 < found.error < 1e-5

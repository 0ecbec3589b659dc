"""Coupled groups: one step for all, by every scheme; births, deaths and planes; threads; groups left alone."""

import numpy as np
import pytest

from particlecli import simulate
from particlecli.dynamics import plan as plans
from tests.dynamics.coupled.test_attraction import bodies
from tests.dynamics.scenes import scene, system

ATTRACTION = {"type": "attraction", "strength": 1, "softening": 0.3}
SPARKS = {
    "rate": 400,
    "shape": {"type": "ball", "radius": 1},
    "direction": {"axis": [0, 1, 0], "spread": 90},
    "speed": {"uniform": [0, 2]},
    "mass": {"uniform": [0.001, 0.003]},
    "lifetime": {"uniform": [0.2, 0.9]},
    "temperature": 1000,
    "cooling": {"rate": 1},
}


def final(parts, threads=1):
    *_, frame = simulate(scene(**parts), threads=threads)
    return {
        name: np.column_stack([group.ids, group.positions, group.velocities]) for name, group in frame.groups.items()
    }


def few(integrator, **more):
    return {
        "duration": 0.5,
        "fps": 4,
        "precision": "double",
        "particles": {"a": bodies(4, 1), "b": bodies(3, 2)},
        "forces": [{"type": "gravity"}, ATTRACTION],
        "integrator": integrator,
        **more,
    }


@pytest.fixture(scope="module")
def right():
    """Where the few bodies go, by SciPy."""
    from scipy.integrate import solve_ivp

    stars = system(1, **few({"type": "rk4"}))

    def slope(time, state):
        stars.set_state(state)
        return stars.derivative(time)

    end = solve_ivp(slope, (0, 0.5), stars.get_state(), method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    return {"a": end[:12].reshape(3, 4).T, "b": end[24:33].reshape(3, 3).T}


@pytest.mark.parametrize(
    ("integrator", "tolerance", "most_serial_packs"),
    [
        ({"type": "rk4", "dt": 1 / 256}, 1e-6, 32),
        pytest.param({"type": "rk4", "dt": 1 / 256}, 1e-6, 0, marks=pytest.mark.slow),
        pytest.param({"type": "velocity_verlet", "dt": 1 / 256}, 1e-3, 32, marks=pytest.mark.slow),
        ({"type": "velocity_verlet", "dt": 1 / 256}, 1e-3, 0),
        pytest.param({"type": "composition8", "dt": 1 / 64}, 1e-9, 32, marks=pytest.mark.slow),
        pytest.param({"type": "dormand_prince", "tolerance": 1e-9}, 1e-7, 32, marks=pytest.mark.slow),
        pytest.param({"type": "dormand_prince", "tolerance": 1e-9}, 1e-7, 0, marks=pytest.mark.slow),
    ],
)
def test_schemes_agree_with_scipy_in_one_kernel_and_launch_by_launch(
    integrator, tolerance, most_serial_packs, right, monkeypatch
):
    monkeypatch.setattr(plans, "MOST_SERIAL_PACKS", most_serial_packs)
    found = final(few(integrator))
    for name in "ab":
        np.testing.assert_allclose(found[name][:, 1:4], right[name], rtol=0, atol=tolerance)


MANY = {
    "particles": {"stars": bodies(600, 3)},
    "emitters": {"sparks": SPARKS},
    "forces": [{"type": "gravity", "on": ["sparks"]}, ATTRACTION],
    "planes": [{"point": [0, -1, 0], "restitution": 0.5, "friction": 0.2, "on": ["sparks"]}],
    "integrator": {"type": "symplectic_euler", "dt": 0.02, "contact": "end_of_step"},
}


def test_same_scene_same_bits_for_any_number_of_threads():
    runs = [final(MANY, threads) for threads in (1, 3)]
    for name, rows in runs[0].items():
        np.testing.assert_array_equal(runs[1][name], rows)


def test_the_unborn_and_the_dead_act_on_nobody():
    """A heavy particle that is born at ½ s and dies at ¾ s pulls only in between, to the length of a step."""
    heavy = {"bursts": [{"time": 0.5, "count": 1}], "shape": {"type": "point", "center": [0, 2, 0]}, "mass": 10}
    parts = {
        "particles": {"light": {"positions": [[0, 0, 0]], "mass": 1e-9}},
        "emitters": {"heavy": {**heavy, "lifetime": 0.25}},
        "forces": [{"type": "attraction", "strength": 1}],
        "integrator": {"type": "velocity_verlet", "dt": 1 / 512},
        "fps": 8,
    }
    speeds = [frame.groups["light"].velocities[0, 1] for frame in simulate(scene(**parts), threads=1)]
    assert speeds[4] == 0.0
    assert speeds[5] > 0.3
    assert speeds[7] == speeds[6] == speeds[8]
    assert speeds[6] == pytest.approx(0.25 * 10 / 4, rel=0.04)


def test_a_group_that_nothing_couples_moves_as_if_it_were_alone():
    alone = {"emitters": {"sparks": SPARKS}, "forces": [{"type": "gravity"}]}
    beside = {
        "particles": {"stars": bodies(5, 4)},
        "emitters": {"sparks": SPARKS},
        "forces": [{"type": "gravity"}, {**ATTRACTION, "on": ["stars"]}],
    }
    np.testing.assert_array_equal(final(beside)["sparks"], final(alone)["sparks"])


def test_deaths_and_cooling_go_as_in_groups_of_single_particles():
    """An attraction too weak to be felt changes nothing but how particles are advanced."""
    parts = {**MANY, "particles": {}, "precision": "double"}
    weak = {**parts, "forces": [{"type": "gravity"}, {"type": "attraction", "strength": 1e-30}]}
    alone = {**parts, "forces": [{"type": "gravity"}]}
    *_, together = simulate(scene(**weak), threads=1)
    *_, single = simulate(scene(**alone), threads=1)
    mine, theirs = together.groups["sparks"], single.groups["sparks"]
    np.testing.assert_array_equal(mine.ids, theirs.ids)
    np.testing.assert_allclose(mine.temperatures, theirs.temperatures, rtol=1e-12)
    np.testing.assert_allclose(mine.ages, theirs.ages, rtol=1e-12)
    np.testing.assert_allclose(mine.positions, theirs.positions, rtol=0, atol=1e-9)

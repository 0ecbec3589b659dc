"""The exact integrator against matrix exponentials, in every regime of damping, however long the step."""

import numpy as np
import pytest
from scipy.linalg import expm

from particlecli.simulate import Simulation
from tests.dynamics.scenes import body, scene, system

G = np.array([0.1, -9.81, 0.0])
GRAVITY = {"type": "gravity", "acceleration": G.tolist()}
WIND = np.array([1.0, 2.0, 3.0])
START = np.array([1.0, 0.5, -0.3, 0.2, -0.6, 0.8])


def advanced(duration, steps=1, precision="double", masses=(1.0,), start=START, **parts):
    """States, shape (n, 6), after steps of the exact integrator; one particle for each mass."""
    made = system(
        precision=precision,
        particles={
            "a": {
                "positions": [start[:3].tolist()] * len(masses),
                "velocities": [start[3:].tolist()] * len(masses),
                "masses": list(masses),
            }
        },
        integrator={"type": "exact"},
        **parts,
    )
    outcome = made.groups["a"].advance(0.0, duration, steps)
    assert outcome.failed_slot is None
    return made.get_state().reshape(6, -1).T


def right(duration, K, D, force, mass=1.0, start=START):
    """The state after a time of m x″ = K x + D x′ + f + m g, by a matrix exponential."""
    matrix = np.zeros((7, 7))
    matrix[:3, 3:6] = np.eye(3)
    matrix[3:6, :3] = np.asarray(K) / mass
    matrix[3:6, 3:6] = np.asarray(D) / mass
    matrix[3:6, 6] = np.asarray(force) / mass + G
    return (expm(matrix * duration) @ np.append(start, 1.0))[:6]


def assert_right(found, duration, K, D, force, masses, tolerance):
    for factor in (1.0, 1.001):
        truth = np.array([right(duration, factor * np.array(K), D, force, mass) for mass in masses])
        error = np.abs(found - truth).max(axis=1) / np.abs(truth).max(axis=1)
        if factor == 1.0:
            assert error.max() < tolerance
        else:
            assert np.median(error) > tolerance


STIFFNESS = np.diag([-40.0, -2.0, 0.5])
"""Two springs and something that repels."""
CRITICAL = 3.0**2 / (4 * 40.0)
"""The mass at which a drag of 3 kg/s damps the first spring critically."""
MASSES = np.concatenate([np.geomspace(3e-3, 1e4, 60), CRITICAL * (1 + np.array([0, 1e-15, -1e-9, 1e-6]))])


@pytest.mark.parametrize("precision", ["double", pytest.param("single", marks=pytest.mark.slow)])
def test_springs_and_drag_in_every_regime_of_damping(precision):
    found = advanced(
        1.5,
        precision=precision,
        masses=MASSES,
        flows={"wind": [{"type": "uniform", "velocity": WIND.tolist()}]},
        forces=[
            GRAVITY,
            {"type": "force_field", "potential": "20*(x - 1)**2 + y**2 - 0.25*z**2"},
            {"type": "drag", "coefficient": 3.0, "flow": "wind"},
        ],
    )
    force = np.array([40.0, 0.0, 0.0]) + 3.0 * WIND
    tolerance = 1e-13 if precision == "double" else 1e-5
    assert_right(found, 1.5, STIFFNESS, -3.0 * np.eye(3), force, MASSES, tolerance)


@pytest.mark.slow
def test_axes_that_are_not_the_coordinates():
    found = advanced(
        2.0,
        masses=(0.5, 2.0, 7.0),
        forces=[
            GRAVITY,
            {"type": "force_field", "potential": "3*(x - y)**2 + (y + z - 1)**2"},
            {"type": "force_field", "force": ["-0.2*u", "-0.2*v", "1 - 0.2*w"]},
        ],
    )
    K = -np.array([[6.0, -6.0, 0.0], [-6.0, 8.0, 2.0], [0.0, 2.0, 2.0]])
    assert_right(found, 2.0, K, -0.2 * np.eye(3), [0.0, 2.0, 3.0], (0.5, 2.0, 7.0), 1e-13)


@pytest.fixture(scope="module")
def dragged():
    """What a drag of 1 kg/s in still air leaves of a velocity of 1 m/s in 1 s, by mass, with the way."""
    masses = np.concatenate([np.geomspace(1e-9, 1e9, 41), [1e-3]])
    found = advanced(
        1.0,
        masses=masses,
        start=np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
        forces=[{"type": "drag", "coefficient": 1.0}],
    )
    return masses, found[:, 3], found[:, 0]


def test_drag_slows_down_exactly_and_never_too_much(dragged):
    masses, speed, way = dragged
    np.testing.assert_allclose(speed, np.exp(-1 / masses), rtol=1e-14, atol=1e-300)
    np.testing.assert_allclose(way, -masses * np.expm1(-1 / masses), rtol=1e-15)
    assert (speed >= 0).all()


def test_stiff_drag_falls_to_the_speed_of_the_wind_without_overshoot():
    heights = [
        advanced(
            0.1 * steps,
            steps=steps,
            forces=[GRAVITY, {"type": "drag", "coefficient": 1e4, "flow": "wind"}],
            flows={"wind": [{"type": "expression", "velocity": ["1", "2", "3"]}]},
        )[0, 3:]
        for steps in (1, 2, 3)
    ]
    final = WIND + G / 1e4
    # k dt / m is 1000: after one step nothing is left of the start.
    np.testing.assert_allclose(heights, np.tile(final, (3, 1)), rtol=1e-13)


def test_damped_oscillators_of_the_textbook():
    found = advanced(
        1.0,
        start=np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
        forces=[{"type": "force_field", "force": ["-100*x - 2*u", "-100*y - 20*v", "-100*z - 40*w"]}],
    )[0]
    np.testing.assert_allclose(found[:3], [-0.33685168054, 4.99399227e-4, 0.07390407190962], rtol=2e-9)


@pytest.mark.slow
def test_the_number_of_steps_does_not_matter():
    forces = [
        {"type": "force_field", "potential": "2e5*x**2 + 7*y**2 + 1e-12*z**2"},
        {"type": "drag", "coefficient": 0.01},
    ]
    one, many = (advanced(3.0, steps=steps, forces=forces) for steps in (1, 100))
    np.testing.assert_allclose(one, many, rtol=1e-11, atol=1e-11)


def test_a_uniform_flow_carries_exactly_in_one_step_a_frame():
    described = scene(
        precision="double",
        fps=2,
        flows={"wind": [{"type": "uniform", "velocity": [1, 0, 0]}, {"type": "uniform", "velocity": [0, 2, 0]}]},
        particles={"a": {"positions": [[1, 1, 1]], "motion": "first_order", "flow": "wind"}},
        integrator={"type": "exact"},
    )
    simulation = Simulation(described)
    frames = [frame.groups["a"].positions.copy() for frame in simulation]
    assert simulation.plan.steps_per_frame == 1
    np.testing.assert_array_equal(np.concatenate(frames), [[1, 1, 1], [1.5, 2, 1], [2, 3, 1]])


@pytest.mark.slow
def test_bounces_and_rest_are_exact_too():
    described = scene(
        precision="double",
        duration=1.4,
        particles={"a": body((0.0, 1.0, 0.0), (0.0, 0.0, 0.0))},
        forces=[{"type": "gravity", "acceleration": [0, -9.81, 0]}],
        planes=[{"restitution": 0.5}],
        integrator={"type": "exact", "dt": 0.1},
    )
    simulation = Simulation(described)
    heights = [float(frame.groups["a"].positions[0, 1]) for frame in simulation]
    first = np.sqrt(2 / 9.81)
    since = 0.5 - first
    assert heights[5] == pytest.approx(0.5 * 9.81 * first * since - 9.81 / 2 * since**2, abs=1e-12)
    assert heights[-1] == 0.0


def test_spreading_sparks_are_where_the_formula_says():
    described = scene(
        precision="double",
        fps=2,
        emitters={"sparks": {"rate": 40, "lifetime": 5, "speed": 2, "direction": {"axis": [0, 1, 0]}}},
        forces=[{"type": "gravity", "acceleration": [0, -10, 0]}, {"type": "drag", "coefficient": 4.0}],
        integrator={"type": "exact"},
    )
    group = list(Simulation(described))[-1].groups["sparks"]
    height = (2 + 2.5) / 4 * -np.expm1(-4 * group.ages) - 2.5 * group.ages
    assert len(height) == 40
    np.testing.assert_allclose(group.positions[:, 1], height, atol=1e-14)

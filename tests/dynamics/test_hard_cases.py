"""Stability where it is hard: close encounters, unequal masses, spin, steps in a force, far from the origin."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.dynamics.scenes import body, system

G = 9.81


def driven(scheme, force, velocity=(0.0, 0.0, 0.0), position=(1.0, 0.0, 0.0), **more):
    return system(
        precision="double",
        particles={"a": body(position, velocity)},
        forces=[{"type": "force_field", "force": force}],
        integrator={"type": scheme, **more},
    )


@pytest.fixture(scope="module")
def pair():
    """Two bodies that attract each other without softening, the first a million times as heavy as the second."""
    return system(
        1,
        precision="double",
        particles={"a": {"positions": [[0, 0, 0], [1, 0, 0]], "masses": [1e6, 1]}},
        forces=[{"type": "attraction", "strength": 1e-6}],
        integrator={"type": "dop853", "tolerance": 1e-12},
    )


HEAVY, LIGHT = 1e6 / (1e6 + 1), 1 / (1e6 + 1)
"""Shares of the two in the mass."""
PULL = 1e-6 * (1e6 + 1)
"""G (M + m), m³/s²."""


def orbited(pair, transverse, turns, tolerance=1e-12):
    """States (6, 2) after turns of an orbit that begins 1 m apart, with the centre of mass at rest at the origin."""
    pair.restart()
    pair.coupled.tolerance = tolerance
    start = np.zeros((6, 2))
    start[0] = -LIGHT, HEAVY
    start[4] = -LIGHT * transverse, HEAVY * transverse
    pair.set_state(start.ravel())
    axis = 1 / (2 - transverse**2 / PULL)
    pair.advance(turns * 2 * math.pi * math.sqrt(axis**3 / PULL))
    return start, pair.get_state().reshape(6, 2)


def test_a_head_on_encounter_without_softening_brings_them_back(pair):
    """They pass each other 2.5·10⁻⁵ m apart, at 280 m/s, and come back to where they were at rest but for 1 cm/s."""
    start, end = orbited(pair, 0.01, 1)
    np.testing.assert_allclose(end, start, rtol=0, atol=1e-6)
    start, rough = orbited(pair, 0.01, 1, tolerance=1e-5)
    assert np.abs(rough - start).max() > 1e-4


def test_a_light_body_beside_a_heavy_one_moves_it_as_it_should(pair):
    _, end = orbited(pair, math.sqrt(1.5), 2.5)
    apart = 2 / (2 - 1.5 / PULL) - 1
    recoil, light = end[0, 0], end[0, 1]
    assert light == pytest.approx(-HEAVY * apart, abs=1e-9)
    assert recoil == pytest.approx(LIGHT * apart, rel=1e-6)
    momentum = end[3:] @ [1e6, 1]
    assert np.abs(momentum).max() < 1e-9


@pytest.mark.slow
def test_fast_spin_is_stable_and_keeps_its_speed():
    """A charge in a magnetic field that turns it 10⁴ times a second, in steps of many turns."""
    spin = ["1e5*w", "0", "-1e5*u"]
    made = driven("implicit_midpoint", spin, (1.0, 0.5, 0.0))
    made.groups["a"].advance(0.0, 1.0, 100)
    state = made.get_state()
    assert np.hypot(state[3], state[5]) == pytest.approx(1.0, rel=1e-9)
    assert state[1] == pytest.approx(0.5, rel=1e-12)
    assert np.hypot(state[0] - 1.0, state[2]) < 0.1
    damped = driven("implicit_euler", spin, (1.0, 0.5, 0.0))
    damped.groups["a"].advance(0.0, 1.0, 100)
    assert np.hypot(*damped.get_state()[[3, 5]]) < 1e-3


@pytest.mark.parametrize(("scheme", "tolerance", "most"), [("dormand_prince", 1e-9, 1e-4), ("dop853", 1e-11, 1e-7)])
def test_a_step_in_the_force_costs_steps_and_little_accuracy(scheme, tolerance, most):
    """A mass between two constant forces, of 1 N from the right and 4 N from the left."""
    made = driven(scheme, ["where(x > 0, -1, 4)", 0, 0], tolerance=tolerance)
    group = made.groups["a"]
    errors = []
    for allowed in (tolerance, 1e-3):
        made.restart()
        group.plan = replace(group.plan, tolerance=allowed)
        for turn in range(1, 6):
            made.advance(turn * 2 * math.sqrt(2) * (1 + 1 / 4))
        errors.append(np.abs(made.get_state() - [1, 0, 0, 0, 0, 0]).max())
    assert errors[0] < most < errors[1]


def test_single_precision_far_away_is_as_good_as_its_rounding():
    """1000 km from the origin a coordinate is known to 6 cm, and steps of less do not vanish altogether."""
    found = {}
    for precision in ("single", "double"):
        made = system(
            precision=precision,
            particles={"a": body((1e6, 1e6, 0.0), (30.0, 40.0, 1.0))},
            forces=[{"type": "gravity", "acceleration": [0, -G, 0]}, {"type": "drag", "coefficient": 0.1}],
            integrator={"type": "rk4", "dt": 0.05},
        )
        for frame in range(1, 51):
            made.advance(frame / 10)
        found[precision] = made.get_state()
    single, double = found["single"], found["double"]
    rounding = 0.5 * np.spacing(np.float32(1e6))
    np.testing.assert_allclose(single[:2], double[:2], atol=100 * rounding)
    np.testing.assert_allclose(single[2:], double[2:], rtol=1e-4)


def energy_of_kepler(scheme, periods, steps, samples):
    """Relative errors of the energy on an orbit of eccentricity ½, at instants spread over many turns."""
    made = system(
        1,
        precision="double",
        particles={"a": body((0.5, 0.0, 0.0), (0.0, math.sqrt(3), 0.0))},
        forces=[{"type": "point_gravity", "strength": 1.0}],
        integrator={"type": scheme},
    )
    dt = 2 * math.pi / steps
    each = round(periods * steps / samples)
    errors = []
    for index in range(samples):
        made.groups["a"].advance(index * each * dt, each * dt, each)
        x, v = np.split(made.get_state(), 2)
        errors.append((0.5 * v @ v - 1 / np.linalg.norm(x) + 0.5) / 0.5)
    return np.array(errors)


def slope_in_errors(values, windows=40):
    """The slope of a line through the means of windows, in standard errors of it."""
    means = np.array([part.mean() for part in np.array_split(values, windows)])
    place = np.arange(windows) - (windows - 1) / 2
    slope = place @ means / (place @ place)
    rest = means - means.mean() - slope * place
    return slope / math.sqrt(rest @ rest / (windows - 2) / (place @ place))


@pytest.mark.slow
def test_ten_thousand_turns_of_kepler_leave_the_energy_where_it_was():
    errors = energy_of_kepler("yoshida4", 10_000, 101, 4001)
    early = np.abs(errors[:400]).max()
    assert early < 5e-4
    assert np.abs(errors).max() < 1.01 * early
    assert abs(slope_in_errors(errors)) < 3
    drifting = energy_of_kepler("rk4", 1000, 101, 400)
    assert abs(slope_in_errors(drifting)) > 100


@pytest.mark.parametrize("scheme", ["implicit_euler", pytest.param("implicit_midpoint", marks=pytest.mark.slow)])
def test_sliding_that_ends_within_a_step_ends_in_rest(scheme):
    """Whatever direction it has: the search for the instant ends where velocities are nothing but rounding."""
    turns = np.random.default_rng(1).uniform(0, 2 * math.pi, 400)
    speeds = np.linspace(0.01, 0.09, 400)
    made = system(
        1,
        precision="double",
        particles={
            "a": {
                "positions": [[1.5, 0, 0.9]] * 400,
                "velocities": (speeds * np.array([np.cos(turns), 0 * turns, np.sin(turns)])).T.tolist(),
            }
        },
        forces=[
            {"type": "gravity", "acceleration": [0, -G, 0]},
            {"type": "quadratic_drag", "coefficient": 0.08},
        ],
        planes=[{"friction": 0.3}],
        integrator={"type": scheme},
    )
    assert made.groups["a"].advance(0.0, 1 / 30, 1).failed_slot is None
    state = made.get_state().reshape(6, -1)
    np.testing.assert_array_equal(state[3:], 0.0)
    way = np.hypot(state[0] - 1.5, state[2] - 0.9)
    right = np.log1p(0.08 * speeds**2 / (0.3 * G)) / 0.16
    np.testing.assert_allclose(way, right, rtol=1.0 if scheme == "implicit_euler" else 1e-3)

"""Planes: impact, rest, friction, sticking and death, against closed forms."""

import math

import numpy as np
import pytest

from tests.cases import later
from tests.dynamics.scenes import body, system

G = 9.81
DOWN = {"type": "gravity", "acceleration": [0, -G, 0]}


def advanced(until, **parts):
    made = system(precision="double", **parts)
    frames = round(until * 10)
    for frame in range(1, frames + 1):
        made.advance(frame / 10)
    return made


def motion(made, group="a"):
    x, y, z, u, v, w = made.groups[group].state.read(("x", "y", "z", "u", "v", "w"))[:, 0]
    return np.array([x, y, z]), np.array([u, v, w])


@pytest.mark.parametrize("restitution", [0.5, *later(1.0, 0.2)])
def test_rebound_has_the_share_of_speed_that_restitution_leaves(restitution):
    made = advanced(
        1.0,
        particles={"a": body((0, 1, 0), (0, -3.0, 0))},
        planes=[{"restitution": restitution}],
        integrator={"type": "rk4", "dt": 0.001},
    )
    position, velocity = motion(made)
    assert velocity[1] == pytest.approx(3.0 * restitution)
    assert position[1] == pytest.approx(3.0 * restitution * (1.0 - 1 / 3), abs=0.01)


def test_tilted_plane_turns_only_the_normal_part():
    normal = np.array([1.0, 2.0, -0.5])
    normal /= np.linalg.norm(normal)
    velocity = np.array([-1.0, -2.0, 0.7])
    made = advanced(
        1.0,
        particles={"a": body(tuple(0.3 * normal), tuple(velocity))},
        planes=[{"normal": [1, 2, -0.5], "restitution": 0.6}],
        integrator={"type": "euler", "dt": 0.001},
    )
    expected = velocity - 1.6 * (velocity @ normal) * normal
    np.testing.assert_allclose(motion(made)[1], expected, rtol=1e-12)


def test_particle_moving_away_below_the_plane_is_left_alone():
    made = advanced(0.1, particles={"a": body((0, -1, 0), (0, 2.0, 0))}, planes=[{"restitution": 0.0}])
    np.testing.assert_allclose(motion(made)[1], [0, 2, 0])


@pytest.mark.parametrize("scheme", ["rk4", "velocity_verlet", *later("euler", "midpoint", "symplectic_euler")])
def test_ball_comes_to_rest_and_neither_sinks_nor_creeps(scheme):
    made = advanced(
        3.0,
        particles={"a": body((0.25, 0.5, 0), (0.0, 0.0, 0.0))},
        forces=[DOWN],
        planes=[{"restitution": 0.5, "friction": 0.5}],
        integrator={"type": scheme, "dt": 0.002},
    )
    position, velocity = motion(made)
    np.testing.assert_allclose(position, [0.25, 0, 0], atol=1e-12)
    np.testing.assert_allclose(velocity, 0, atol=1e-12)


@pytest.mark.parametrize(("friction", "slides"), [(0.2, True), (0.7, False)])
def test_incline_of_thirty_degrees_slides_below_the_friction_angle_only(friction, slides):
    normal = np.array([math.sin(math.pi / 6), math.cos(math.pi / 6), 0.0])
    made = advanced(
        1.0,
        particles={"a": body((0, 0, 0), (0, 0, 0))},
        forces=[DOWN],
        planes=[{"normal": tuple(normal), "friction": friction, "restitution": 0.0}],
        integrator={"type": "rk4", "dt": 0.001},
    )
    position, _ = motion(made)
    acceleration = G * (math.sin(math.pi / 6) - friction * math.cos(math.pi / 6))
    expected = 0.5 * acceleration if slides else 0.0
    assert np.linalg.norm(position) == pytest.approx(expected, rel=5e-3, abs=1e-12)
    assert position @ normal == pytest.approx(0.0, abs=1e-12)


def test_flat_slide_stops_where_coulomb_friction_says():
    made = advanced(
        2.0,
        particles={"a": body((0, 0, 0), (5.0, 0, 0))},
        forces=[DOWN],
        planes=[{"friction": {"coulomb": 0.3}, "restitution": 0.0}],
        integrator={"type": "rk4", "dt": 0.001},
    )
    position, velocity = motion(made)
    assert position[0] == pytest.approx(4.247366632687734, rel=2e-3)
    np.testing.assert_array_equal(velocity, 0.0)


def test_viscous_friction_slows_a_resting_slider_exponentially():
    made = advanced(
        1.0,
        particles={"a": body((0, 0, 0), (5.0, 0, 0))},
        forces=[DOWN],
        planes=[{"friction": {"viscous": 0.2}, "restitution": 0.0}],
        integrator={"type": "rk4", "dt": 0.001},
    )
    assert motion(made)[1][0] == pytest.approx(5.0 * math.exp(-0.2 * G), rel=1e-9)


def test_impact_friction_is_bounded_by_the_normal_impulse():
    made = advanced(
        0.2,
        particles={"a": body((0, 0.1, 0), (3.0, -2.0, 0.0))},
        planes=[{"friction": 0.25, "restitution": 0.5}],
        integrator={"type": "euler", "dt": 0.001},
    )
    np.testing.assert_allclose(motion(made)[1], [3.0 - 0.25 * 3.0, 1.0, 0.0], rtol=1e-12)


def test_sticking_particle_stays_for_good():
    made = advanced(
        1.0,
        particles={"a": body((0, 0.5, 0), (1.0, -2.0, 0))},
        forces=[DOWN],
        planes=[{"on_hit": "stick"}],
        integrator={"type": "rk4", "dt": 0.001},
    )
    position, velocity = motion(made)
    hit = (-2 + math.sqrt(4 + 2 * G * 0.5)) / G
    np.testing.assert_allclose(position, [hit, 0, 0], atol=2e-3)
    np.testing.assert_array_equal(velocity, 0)
    assert made.deaths["a"] == {}


def test_deadly_plane_is_a_cause_of_death():
    made = advanced(
        1.0,
        particles={"a": {"positions": [[0, 0.5, 0], [0, 90, 0]]}},
        forces=[DOWN],
        planes=[{"on_hit": "die"}],
    )
    assert made.deaths["a"] == {"plane": 1}
    assert made.alive == 1


def test_first_order_particles_slide_along_a_plane_their_flow_points_into():
    made = advanced(
        1.0,
        flows={"f": [{"type": "uniform", "velocity": [1.0, -1.0, 0.0]}]},
        particles={"a": {"positions": [[0, 0.5, 0]], "motion": "first_order", "flow": "f"}},
        planes=[{}],
        integrator={"type": "rk4", "dt": 0.01},
    )
    np.testing.assert_allclose(made.get_state(), [1.0, 0.0, 0.0], atol=1e-12)

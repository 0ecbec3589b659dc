"""Planes that ride on coordinate frames: lifts, rackets, belts and turntables."""

import numpy as np
import pytest

from particlecli.simulate import Simulation
from tests.cases import later
from tests.dynamics.scenes import scene

GRAVITY = {"type": "gravity", "acceleration": [0, -10, 0]}


def end(frames, plane, particles, duration=1.0, forces=(GRAVITY,), scheme="symplectic_euler"):
    described = scene(
        duration=duration,
        fps=10,
        precision="double",
        frames=frames,
        particles={"a": particles},
        forces=list(forces),
        planes=[{"frame": "f", "restitution": 0, **plane}],
        integrator={"type": scheme, "dt": 0.001},
    )
    return list(Simulation(described))[-1].groups["a"]


def test_a_lift_takes_what_rests_on_it_along():
    group = end({"f": {"translate": [0, "0.5*t**2", 0]}}, {"normal": [0, 1, 0]}, {"positions": [[0, 0, 0]]})
    np.testing.assert_allclose(group.positions[0], [0, 0.5, 0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(group.velocities[0], [0, 1, 0], rtol=0, atol=2e-3)


@pytest.mark.parametrize("scheme", ["symplectic_euler", pytest.param("implicit_euler", marks=pytest.mark.slow)])
def test_a_lift_takes_a_body_of_particles_along(scheme):
    springs = {"type": "springs", "stiffness": 10, "pairs": [[0, 1]]}
    group = end(
        {"f": {"translate": [0, "0.5*t**2", 0]}},
        {"normal": [0, 1, 0]},
        {"positions": [[0, 0, 0], [1, 0, 0]]},
        forces=[GRAVITY, springs],
        scheme=scheme,
    )
    np.testing.assert_allclose(group.positions, [[0, 0.5, 0], [1, 0.5, 0]], rtol=0, atol=1e-12)
    np.testing.assert_allclose(group.velocities, [[0, 1, 0]] * 2, rtol=0, atol=2e-3)


def test_a_racket_gives_its_own_speed_once_and_the_rebound_on_top():
    group = end(
        {"f": {"translate": ["3*t", 0, 0]}},
        {"normal": [1, 0, 0], "restitution": 0.5},
        {"positions": [[1, 0, 0]], "velocities": [[-1, 2, 0]]},
        forces=[],
    )
    np.testing.assert_allclose(group.velocities[0], [3 + 0.5 * 4, 2, 0], rtol=0, atol=1e-12)


def test_a_belt_draws_along_until_nothing_slides():
    belt = {"translate": ["2*t", 0, 0]}
    group = end({"f": belt}, {"normal": [0, 1, 0], "friction": 0.1}, {"positions": [[0, 0, 0]]}, duration=1.0)
    np.testing.assert_allclose(group.velocities[0], [1, 0, 0], rtol=0, atol=5e-3)
    np.testing.assert_allclose(group.positions[0], [0.5, 0, 0], rtol=0, atol=5e-3)
    group = end({"f": belt}, {"normal": [0, 1, 0], "friction": 0.1}, {"positions": [[0, 0, 0]]}, duration=3.0)
    np.testing.assert_allclose(group.velocities[0], [2, 0, 0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(group.positions[0], [2 + 2, 0, 0], rtol=0, atol=1e-2)


def test_a_turning_plane_strikes_with_the_speed_of_its_point():
    turn = {"rotate": {"axis": [0, 0, 1], "angle": "2*t"}}
    group = end(
        {"f": turn},
        {"normal": [0, 1, 0], "restitution": 1},
        {"positions": [[1, 0.1, 0]], "velocities": [[0, 0, 0.5]]},
        forces=[],
        duration=0.3,
    )
    angle = np.arctan(0.1)
    speed = 2 * np.hypot(1, 0.1)
    normal = np.array([-np.sin(angle), np.cos(angle), 0])
    np.testing.assert_allclose(group.velocities[0], 2 * speed * normal + [0, 0, 0.5], rtol=0, atol=1e-2)


@pytest.mark.parametrize("rising", [True, *later(False)])
def test_what_hits_a_moving_plane_dies_where_it_is(rising):
    path = "0.6*t" if rising else "-0.6*t"
    described = scene(
        duration=1,
        fps=10,
        frames={"f": {"translate": [0, path, 0]}},
        particles={"a": {"positions": [[0, 1, 0]]}},
        forces=[GRAVITY],
        planes=[{"frame": "f", "on_hit": "die"}],
        integrator={"type": "rk4", "dt": 0.001},
    )
    simulation = Simulation(described)
    alive = [len(frame.groups["a"]) for frame in simulation]
    # 1 − 5 t² = ±0.6 t
    met = ((-0.6 if rising else 0.6) + np.sqrt(0.36 + 20)) / 10
    assert sum(alive) == int(met * 10) + 1

"""Pins that ride on coordinate frames, against matrices written apart; their rates by complex steps."""

import numpy as np
import pytest
from scipy.linalg import expm

from particlecli.scene.checks import problems
from tests.dynamics.scenes import scene, system

FRAMES = {
    "base": {"rotate": {"axis": [0, 1, 0], "angle": "0.7 + 2*t"}, "translate": [0.3, "0.2*sin(3*t)", 0]},
    "arm": {
        "parent": "base",
        "translate": [0, "1 + 0.1*t**2", 0],
        "rotate": {"axis": [1, 2, 2], "angle": "0.6*sin(5*t)"},
        "scale": "1 + 0.5*t",
    },
}
PLACES = np.array([[0.0, 0.0, 0.0], [1.0, 0.2, 0.1], [2.0, 0.0, -0.3], [3.0, 0.1, 0.0]])
STIFFNESS, DAMPING = 3.0, 0.8
TIMES = (0.0, 0.37, 1.0)


def moved(axis, angle, shift, scale=1.0):
    """A pose as a 4×4 matrix; its arguments may be complex."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    matrix = np.eye(4, dtype=complex)
    matrix[:3, :3] = scale * expm(angle * np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], complex))
    matrix[:3, 3] = shift
    return matrix


def base(t):
    return moved([0, 1, 0], 0.7 + 2 * t, [0.3, 0.2 * np.sin(3 * t), 0])


def arm(t):
    return base(t) @ moved([1, 2, 2], 0.6 * np.sin(5 * t), [0, 1 + 0.1 * t**2, 0], 1 + 0.5 * t)


def carried(t):
    """Where the three pinned ones are at a time: on the arm, along a path on the base, at rest."""
    on_arm, on_base, _ = (
        np.linalg.solve(frame(0.0), [*place, 1]) for frame, place in zip((arm, base, base), PLACES, strict=False)
    )
    on_base = on_base + np.array([0.5 * np.sin(4 * t), 0, on_base[1] * t, 0])
    return np.stack([(arm(t) @ on_arm)[:3], (base(t) @ on_base)[:3], PLACES[2] + 0j])


def velocities(t):
    return carried(t + 1e-30j).imag / 1e-30


def accelerations(t, h=1e-4):
    return (8 * (velocities(t + h) - velocities(t - h)) - (velocities(t + 2 * h) - velocities(t - 2 * h))) / (12 * h)


@pytest.fixture(scope="module")
def pinned():
    return system(
        1,
        precision="double",
        frames=FRAMES,
        particles={
            "rope": {
                "positions": PLACES.tolist(),
                "pins": [
                    {"where": "x < 0.5", "frame": "arm"},
                    {"where": "x < 1.5", "frame": "base", "path": ["x + 0.5*sin(4*t)", "y", "z + y*t"]},
                    {"where": "x < 2.5"},
                ],
            }
        },
        forces=[{"type": "springs", "stiffness": STIFFNESS, "damping": DAMPING, "pairs": [[0, 3]], "rest_length": 1}],
        integrator={"type": "rk4", "dt": 0.01},
    )


def test_pins_follow_the_composed_frames_with_their_velocity(pinned):
    pinned.restart()
    for time in TIMES:
        pinned.advance(time)
        x, v = pinned.get_state().reshape(2, 3, 4).transpose(0, 2, 1)
        np.testing.assert_allclose(x[:3], carried(time).real, rtol=0, atol=1e-12)
        np.testing.assert_allclose(v[:3], velocities(time), rtol=0, atol=1e-12)


@pytest.mark.parametrize("time", TIMES)
def test_what_hangs_on_a_pin_feels_its_velocity(pinned, time):
    """And the slopes of pinned particles are their velocities and accelerations."""
    pinned.restart()
    pinned.advance(time)
    x, v = pinned.get_state().reshape(2, 3, 4).transpose(0, 2, 1)
    slope = pinned.derivative(time).reshape(2, 3, 4).transpose(0, 2, 1)
    np.testing.assert_allclose(slope[0, :3], velocities(time), rtol=0, atol=1e-12)
    np.testing.assert_allclose(slope[1, :3], accelerations(time), rtol=0, atol=1e-9)
    span, closing = x[0] - x[3], v[0] - v[3]
    length = np.linalg.norm(span)
    pull = (STIFFNESS * (length - 1) + DAMPING * closing @ span / length) * span / length
    np.testing.assert_allclose(slope[1, 3], pull, rtol=0, atol=1e-12)


def test_a_pin_on_no_frame_is_refused():
    group = {"positions": PLACES.tolist(), "pins": [{"where": "x < 1", "frame": "arms"}]}
    force = {"type": "springs", "stiffness": 1, "pairs": [[0, 1]]}
    found = dict(problems(scene(particles={"rope": group}, forces=[force], frames=FRAMES, integrator={"type": "rk4"})))
    assert 'did you mean "arm"' in found["particles", "rope", "pins", 0, "frame"]

"""Grains that stick until they slip."""

import numpy as np
import pytest

from particlecli.scene.model import Scene
from particlecli.simulate import Simulation

DIAMETER, STIFFNESS, MASS, G, FRICTION = 0.1, 2000.0, 0.01, 9.8, 0.5
DIP = MASS * G / STIFFNESS


@pytest.fixture(scope="module")
def tilted():
    """Positions and velocities at all frames of a grain on top of one that is held, gravity tilted by an angle."""
    made = []

    def of(angle):
        gravity = [G * np.sin(angle), -G * np.cos(angle), 0.0]
        scene = {
            "duration": 1.5,
            "fps": 20,
            "precision": "double",
            "particles": {
                "grains": {
                    "positions": [[0, 0, 0], [0, DIAMETER - DIP, 0]],
                    "masses": [MASS, MASS],
                    "pins": [{"where": "y < 0.05"}],
                }
            },
            "forces": [
                {"type": "gravity", "acceleration": gravity},
                {
                    "type": "soft_sphere",
                    "diameter": DIAMETER,
                    "stiffness": STIFFNESS,
                    "damping": 3.0,
                    "friction": FRICTION,
                },
            ],
            "integrator": {"type": "symplectic_euler", "dt": 1e-3},
        }
        made.append(Simulation(Scene.model_validate(scene)))
        frames = [frame.groups["grains"] for frame in made[-1]]
        return np.array([f.positions[1] for f in frames]), np.array([f.velocities[1] for f in frames])

    return of


def test_a_grain_that_friction_holds_is_where_its_tangential_spring_balances_and_does_not_creep(tilted):
    angle = np.arctan(0.8 * FRICTION)
    x, v = tilted(angle)
    slid = MASS * G * np.sin(angle) / (2 / 7 * STIFFNESS)
    assert x[-1, 0] == pytest.approx(slid, rel=0.03)
    assert np.abs(x[-1] - x[15]).max() < 1e-12
    assert np.abs(v[-1]).max() < 1e-12


def test_a_grain_that_friction_does_not_hold_slips_off(tilted):
    x, _ = tilted(np.arctan(1.2 * FRICTION))
    assert x[-1, 1] < 0.0

"""A liquid of Lennard-Jones atoms near its triple point keeps its energy and its momentum."""

import numpy as np
import pytest

from particlecli.scene.model import Scene
from particlecli.simulate import Simulation

CELLS, DENSITY, DT, EVERY = 7, 0.8442, 0.004, 20
COUNT = 4 * CELLS**3


def drifts(**options):
    """Over 10,000 steps, in parts of the kinetic energy, the drift of the energy; and that of the momentum."""
    rng, edge = np.random.default_rng(1), (COUNT / DENSITY) ** (1 / 3)
    corners = np.stack(np.meshgrid(*[np.arange(CELLS)] * 3), -1).reshape(-1, 1, 3)
    sites = corners + 0.5 * np.array([[0, 0, 0], [0, 1, 1], [1, 0, 1], [1, 1, 0]]) + 0.25
    velocities = rng.normal(0.0, 1.2, (COUNT, 3))
    atoms = {"positions": (sites.reshape(-1, 3) * edge / CELLS).tolist(), "velocities": velocities.tolist()}
    box = {"min": [0, 0, 0], "max": [edge] * 3}
    scene = {
        "duration": 1e3,
        "fps": 1 / (EVERY * DT),
        "precision": "double",
        "particles": {"atoms": atoms},
        "forces": [{"type": "lennard_jones", "periodic": box, **options}],
        "integrator": {"type": "velocity_verlet", "dt": DT},
    }
    system = Simulation(Scene.model_validate(scene), fields={"atoms": frozenset()}).system
    system.advance(0.0)
    kinetic, total = [], []
    for frame in range(600):
        system.advance(system.time + EVERY * DT)
        if frame >= 100:
            v = system.get_state().reshape(6, -1)[3:]
            kinetic.append(0.5 * (v**2).sum())
            total.append(kinetic[-1] + system.coupled.potential_energies(system.time)["atoms"].sum())
    momentum = np.abs(v.sum(axis=1) - velocities.sum(axis=0)).max() / np.abs(v).sum()
    return np.polyfit(np.arange(500), total, 1)[0] * 500 / np.mean(kinetic), momentum


@pytest.mark.slow
def test_energy_does_not_drift_where_the_force_ends_at_zero():
    energy, momentum = drifts()
    assert abs(energy) < 1e-5
    assert momentum < 1e-13


@pytest.mark.slow
def test_a_force_that_jumps_at_the_cutoff_makes_the_energy_drift_no_more_than_told():
    energy, momentum = drifts(shifted="potential")
    assert 1e-5 < abs(energy) < 3e-4
    assert momentum < 1e-13

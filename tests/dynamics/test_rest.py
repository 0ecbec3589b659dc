"""Packs of particles that rest on planes: done together they fare as they do one by one, to the last bit."""

import numpy as np
import pytest

from particlecli.dynamics import group_rest
from tests.dynamics.scenes import system

COUNT, FRAMES, FPS = 80, 50, 30
RNG = np.random.default_rng(8)
POSITIONS = RNG.uniform(-1.0, 1.0, (COUNT, 3)) * [1.0, 0.2, 1.0] + [0.0, 0.2, 0.0]
VELOCITIES = RNG.normal(0.0, 0.8, (COUNT, 3))


@pytest.fixture(scope="module")
def grains():
    """Grains that fall onto a slope, slide, and come to rest one after the other."""
    return system(
        fps=FPS,
        particles={"a": {"positions": POSITIONS.tolist(), "velocities": VELOCITIES.tolist()}},
        forces=[{"type": "gravity", "acceleration": [0, -9.81, 0]}, {"type": "drag", "coefficient": 0.1}],
        planes=[{"normal": [-0.1, 1, 0], "restitution": 0.3, "friction": 0.4}],
        integrator={"type": "symplectic_euler", "dt": 1 / 120},
    )


def states(grains):
    """After each frame."""
    grains.restart()
    found = []
    for frame in range(1, FRAMES + 1):
        grains.advance(frame / FPS)
        found.append(grains.get_state())
    return np.array(found)


def test_packs_rest_as_particles_do_one_by_one(grains, monkeypatch):
    group, together = grains.groups["a"], []
    calmly = group.rest.advance_calmly

    def count_calm(*arguments):
        before = [bits.bit_count() for bits in group.below.to_numpy()]
        calmly(*arguments)
        together.append(sum(before) - sum(bits.bit_count() for bits in group.below.to_numpy()))

    monkeypatch.setattr(group.rest, "advance_calmly", count_calm)
    one_by_one = states(grains)
    assert not together
    monkeypatch.setattr(group_rest, "WORTH", 1000)
    assert np.array_equal(states(grains), one_by_one)
    assert max(together) > COUNT // 2
    speed = np.linalg.norm(one_by_one.reshape(FRAMES, 6, COUNT)[:, 3:], axis=1)
    assert (speed[-1] == 0.0).sum() > COUNT // 2 > (speed[5] == 0.0).sum()

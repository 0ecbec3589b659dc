"""Soft bodies, webs of arbitrary springs and long ropes, so stiff that implicit steps see them as rigid."""

import numpy as np
import pytest

from tests.dynamics.coupled.test_implicit import measured_order
from tests.dynamics.scenes import system

pytestmark = pytest.mark.slow

DT, STEPS, SPIN = 1 / 60, 40, 3.0
STIFFNESS = 1e6
"""N/m, on 10 g: ω dt ≈ 500."""

TURN = {"velocity": [f"-{SPIN}*y", f"{SPIN}*x", 0]}
PARTICLES = 200


def web():
    """Places at random, shape (n, 3), m, each joined with the next and with some others at any distance."""
    rng = np.random.default_rng(4)
    places = rng.uniform(-0.5, 0.5, (PARTICLES, 3))
    pairs = np.concatenate([np.arange(PARTICLES - 1)[:, None] + [0, 1], rng.integers(0, PARTICLES, (600, 2))])
    pairs = np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)
    return places - places.mean(axis=0), pairs


def springs(kind):
    return {"type": "springs", "stiffness": STIFFNESS, **({"pairs": web()[1].tolist()} if kind == "web" else {})}


def body(kind, **more):
    """One that turns about z, at t = 0."""
    layout = {"layout": {"type": "grid", "counts": [6, 6, 6], "spacing": 0.1}, **TURN}
    places = web()[0]
    given = {"positions": places.tolist(), "velocities": np.cross([0, 0, SPIN], places).tolist()}
    parts = {"particles": {"body": {"mass": 0.01, **(given if kind == "web" else layout)}}, "fps": 1 / DT}
    return system(**{"threads": 2, **parts, "forces": [springs(kind)], **more})


def turned(kind, scheme, precision, **more):
    """The states, shape (steps + 1, 6, n), and energies, J."""
    found = body(kind, integrator={"type": scheme, "dt": DT}, precision=precision, **more)
    states, energies = [], []
    for step in range(STEPS + 1):
        found.advance(step * DT)
        states.append(found.get_state().reshape(6, -1))
        potential = found.coupled.potential_energies(found.time)["body"].sum()
        energies.append(0.005 * (states[-1][3:] ** 2).sum() + potential)
    return np.stack(states), np.array(energies)


def spins(states):
    """Of all particles together, kg m²/s, about z."""
    return 0.01 * (states[:, 0] * states[:, 4] - states[:, 1] * states[:, 3]).sum(axis=1)


def spins_by_implicit_euler(first):
    """Of a rigid body: a step turns it by θ after one by θ′, tan θ = sin θ′/(2 − cos θ′); the first by atan ω h."""
    turn = np.arctan(SPIN * DT)
    found = [first]
    for _ in range(STEPS):
        found.append(first * np.sin(turn) / (SPIN * DT))
        turn = np.arctan(np.sin(turn) / (2 - np.cos(turn)))
    return np.array(found)


def worst_strain(states, pairs):
    ends = states[:, :3][:, :, pairs]
    lengths = np.linalg.norm(ends[..., 1] - ends[..., 0], axis=1)
    return np.abs(lengths / lengths[0] - 1).max()


@pytest.mark.parametrize("kind", ["soft body", "web"])
@pytest.mark.parametrize(("scheme", "precision"), [("implicit_euler", "single"), ("tr_bdf2", "double")])
def test_a_stiff_body_turns_as_the_scheme_turns_a_rigid_one(kind, scheme, precision):
    states, energies = turned(kind, scheme, precision)
    momenta = 0.01 * states[:, 3:].sum(axis=2)
    size = 0.01 * np.abs(states[0, 3:]).sum()
    assert np.abs(momenta - momenta[0]).max() < (1e-4 if precision == "single" else 1e-12) * size
    assert energies.max() <= energies[0] * (1 + 1e-5)
    found = spins(states)
    expected = spins_by_implicit_euler(found[0]) if scheme == "implicit_euler" else np.full(STEPS + 1, found[0])
    np.testing.assert_allclose(found, expected, rtol=2e-3)
    grid = np.arange(216).reshape(6, 6, 6)
    along = np.stack([grid[1:].ravel(), grid[:-1].ravel()], axis=1)
    assert worst_strain(states, web()[1] if kind == "web" else along) < 1e-3


def test_a_web_has_the_same_bits_for_any_number_of_threads():
    one, *others = (turned("web", "implicit_euler", "single", threads=threads)[0] for threads in (1, 2, 3))
    for other in others:
        np.testing.assert_array_equal(other, one)


def test_errors_on_a_web_fall_with_the_order_of_the_scheme():
    force = {**springs("web"), "stiffness": 1, "damping": 0.01}
    found = body("web", forces=[force], integrator={"type": "tr_bdf2", "dt": DT}, precision="double")
    assert measured_order(found) == pytest.approx(2, abs=0.2)


def fallen_rope(precision):
    """The lengths of 2000 links of 1 mm, shape (31, links), and the energy, J, of a rope that falls from its pin."""
    links, mass = 2000, 0.001
    places = np.linspace([0, 0, 0], [2, 0, 0], links + 1)
    pairs = np.arange(links)[:, None] + [0, 1]
    found = system(
        2,
        fps=1 / DT,
        precision=precision,
        particles={"rope": {"positions": places.tolist(), "mass": mass, "pins": [{"where": "x < 0.0005"}]}},
        forces=[{"type": "gravity"}, {"type": "springs", "stiffness": STIFFNESS, "pairs": pairs.tolist()}],
        integrator={"type": "implicit_euler", "dt": DT},
    )
    lengths, energies = [], []
    for step in range(31):
        found.advance(step * DT)
        state = found.get_state().reshape(6, -1)
        lengths.append(np.linalg.norm(np.diff(state[:3], axis=1), axis=0))
        stretch = 0.5 * STIFFNESS * ((lengths[-1] - 0.001) ** 2).sum()
        energies.append(stretch + mass * (9.80665 * state[1] + 0.5 * (state[3:] ** 2).sum(axis=0)).sum())
    assert state[1, -1] < -1.0
    return np.stack(lengths), np.array(energies)


@pytest.mark.parametrize("precision", ["single", "double"])
def test_a_rope_of_two_thousand_stiff_links_falls_without_stretching(precision):
    """Its own weight of 20 N and twice as much as it swings stretch a link by 4 in 100; it gains no energy."""
    lengths, energies = fallen_rope(precision)
    assert np.abs(lengths / 0.001 - 1).max() < 0.06
    assert np.diff(energies).max() < 1e-3

"""The modes of particles that act on each other, against those that are known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from particlecli.accuracy import coupled_modes
from particlecli.accuracy.advice import advice, verdict
from particlecli.accuracy.linear_analysis import analyze
from particlecli.accuracy.stability_plot import draw
from tests.cases import later
from tests.dynamics.scenes import scene

N = 9
"""Free particles of the chain."""

STIFFNESS, MASS, LENGTH = 50.0, 0.02, 0.1


def chain(damping=0.0, stretch=1.0, **more):
    """Particles in a row, joined one to the next, the ends held; springs that are `stretch` times their rest length."""
    layout = {"type": "grid", "counts": [N + 2, 1, 1], "spacing": LENGTH}
    end = 0.499 * LENGTH * (N + 1)
    row = {"layout": layout, "mass": MASS, "pins": [{"where": f"abs(x) > {end}"}]}
    springs = {"type": "springs", "stiffness": STIFFNESS, "damping": damping, "links": ["structural"]}
    springs["rest_length"] = f"l/{stretch}"
    return scene(particles={"row": row}, forces=[springs], integrator={"type": "rk4", "dt": 0.001}, **more)


def frequencies(number, along, across):
    """ω² of a chain's modes along it, and of those in each direction across it, shape (3, number)."""
    shapes = 4 * np.sin(np.arange(1, number + 1) * math.pi / (2 * (number + 1))) ** 2
    return np.array([along, across, across])[:, None] * shapes


def oscillating(group):
    rates = group.of_kind("oscillation").rates.imag
    return np.sort(rates[rates > 0])


def only(analysis):
    (group,) = analysis.groups
    return group


def test_a_stretched_chain_has_the_modes_of_a_string():
    stretch = 1.25
    group = only(analyze(chain(stretch=stretch), threads=1))
    k = STIFFNESS / MASS
    expected = np.sqrt(frequencies(N, k, k * (1 - 1 / stretch)).ravel())
    np.testing.assert_allclose(oscillating(group), np.sort(expected), rtol=1e-6)
    assert (group.particles, group.coupled, group.complete, group.ruler) == (N + 2, True, True, "position")
    assert group.position_rate == pytest.approx(expected.max())


def test_damped_springs_slow_each_mode_by_its_stiffness():
    damping = 0.3
    group = only(analyze(chain(damping), threads=1))
    squares = frequencies(N, STIFFNESS / MASS, 0.0)[0]
    slowing = damping / STIFFNESS * squares
    rates = -slowing / 2 + np.sqrt(slowing**2 / 4 - squares + 0j)
    found = group.modes.rates[group.modes.rates.imag > 0]
    order = np.argsort(found.imag)
    np.testing.assert_allclose(found[order], rates[np.argsort(rates.imag)], rtol=1e-6)
    assert len(group.of_kind("free").rates) == 4 * N  # across it, nothing pulls back; positions and velocities
    q = 2 * math.sqrt(2)
    assert group.limits["rk4"].step == pytest.approx(q / np.abs(rates).max(), rel=0.05)
    assert "velocity_verlet" not in group.limits


@pytest.mark.parametrize("damping", [*later(0.0), 0.02])
def test_of_many_particles_the_fastest_modes_are_found(damping, monkeypatch):
    """A membrane of 13 × 9 free particles, all edges held."""
    counts, stretch = [15, 11, 1], 2.0
    half = [0.499 * LENGTH * (count - 1) for count in counts[:2]]
    cloth = {
        "layout": {"type": "grid", "counts": counts, "spacing": LENGTH},
        "mass": MASS,
        "pins": [{"where": f"max(abs(x) > {half[0]}, abs(y) > {half[1]})"}],
    }
    springs = {"type": "springs", "stiffness": STIFFNESS, "damping": damping, "links": ["structural"]}
    forces = [{**springs, "rest_length": f"l/{stretch}"}]
    described = scene(particles={"cloth": cloth}, forces=forces, integrator={"type": "rk4", "dt": 0.001})
    monkeypatch.setattr(coupled_modes, "DENSE", 0)
    group = only(analyze(described, threads=1))
    k = STIFFNESS / MASS
    along, across = (frequencies(n - 2, k, k * (1 - 1 / stretch)) for n in counts[:2])
    fastest = max((along[0][:, None] + across[1][None]).max(), (along[1][:, None] + across[0][None]).max())
    assert not group.complete
    assert group.position_rate == pytest.approx(math.sqrt(fastest), rel=2e-3)
    assert np.abs(group.modes.rates).max() == pytest.approx(math.sqrt(fastest), rel=2e-3)
    assert group.limits["rk4"].step == pytest.approx(2 * math.sqrt(2) / math.sqrt(fastest), rel=0.03)
    assert (group.velocity_rate > 0) == (damping > 0)


def test_two_bodies_fall_apart_along_their_line_and_swing_across_it():
    masses, apart, strength = [3.0, 1.0], 2.0, 5.0
    pair = {"positions": [[0, 0, 0], [apart, 0, 0]], "masses": masses}
    forces = [{"type": "attraction", "strength": strength}]
    described = scene(particles={"pair": pair}, forces=forces, integrator={"type": "velocity_verlet", "dt": 0.01})
    group = only(analyze(described, threads=1))
    pull = strength * sum(masses) / apart**3
    assert group.of_kind("growth").rates.real == pytest.approx([math.sqrt(2 * pull)], rel=1e-6)
    np.testing.assert_allclose(oscillating(group), math.sqrt(pull) * np.ones(2), rtol=1e-6)
    assert len(group.of_kind("free").rates) == 6
    assert group.limits["velocity_verlet"].step == pytest.approx(2 / math.sqrt(pull))


def test_particles_apart_from_the_coupled_ones_are_looked_at_too():
    groups = {"pair": {"positions": [[0, 0, 0], [1, 0, 0]]}, "stone": {"positions": [[5, 0, 0]]}}
    springs = {"type": "springs", "stiffness": 1, "pairs": [[0, 1]], "on": ["pair"]}
    described = scene(particles=groups, forces=[springs, {"type": "drag", "coefficient": 2, "on": ["stone"]}])
    pair, stone = analyze(described, threads=1).groups
    assert (pair.name, pair.coupled, stone.name, stone.coupled) == ("pair", True, "stone", False)
    assert oscillating(pair) == pytest.approx([math.sqrt(2)])
    assert stone.velocity_rate == pytest.approx(2.0)


def test_advice_verdict_and_plot():
    analysis = analyze(chain(stretch=1.25), at=0.05, threads=1)
    group = only(analysis)
    assert "where it and the others are" in advice(group, 0.1)
    assert verdict(analysis).startswith("rk4 is stable")
    assert draw(analysis).axes

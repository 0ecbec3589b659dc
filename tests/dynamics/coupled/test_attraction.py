"""Attraction: against a plain sum, with action equal to reaction, as the gradient of its potential."""

import numpy as np
import pytest

from particlecli.errors import SimulationError
from tests.cases import later
from tests.dynamics.scenes import scene, system

STRENGTH, SOFTENING = 1.7, 0.05


def bodies(count, seed):
    random = np.random.default_rng(seed)
    return {
        "positions": random.normal(size=(count, 3)).tolist(),
        "velocities": random.normal(size=(count, 3)).tolist(),
        "masses": random.uniform(0.5, 2, count).tolist(),
    }


PARTICLES = {"a": bodies(37, 1), "b": bodies(18, 2), "c": bodies(3, 3)}
FORCES = [
    {"type": "attraction", "strength": STRENGTH, "softening": SOFTENING, "on": ["a", "b"]},
    {"type": "attraction", "strength": -0.5, "on": ["b", "c"]},
]


def by_plain_sum(x, mass, strength, softening):
    """Accelerations, shape (3, n), and the potential energy."""
    apart = x[:, None, :] - x[:, :, None]
    distance2 = (apart**2).sum(axis=0) + softening**2
    np.fill_diagonal(distance2, np.inf)
    acceleration = strength * (mass * apart * distance2**-1.5).sum(axis=2)
    return acceleration, -0.5 * strength * (np.outer(mass, mass) / np.sqrt(distance2)).sum()


@pytest.fixture(scope="module", params=[*later("single"), "double"])
def stars(request):
    found = system(1, precision=request.param, particles=PARTICLES, forces=FORCES)
    found.advance(0.0)
    return found


def slopes(stars):
    """Positions, velocities, masses and accelerations by group."""
    values, start = {}, 0
    slope, state = stars.derivative(0.0), stars.get_state()
    for name, group in stars.groups.items():
        span = slice(start, start + 6 * group.state.count)
        parts = state[span].reshape(6, -1), slope[span].reshape(6, -1)
        values[name] = (parts[0][:3], parts[0][3:], np.array(PARTICLES[name]["masses"]), parts[1][3:], parts[1][:3])
        start = span.stop
    return values


def by_groups(found, strength=STRENGTH, softening=SOFTENING, other=-0.5):
    """Accelerations by the plain sum, by group, and the potential energy."""
    x, mass = (np.concatenate([found[name][i] for name in "ab"], axis=-1) for i in (0, 2))
    first, first_energy = by_plain_sum(x, mass, strength, softening)
    x, mass = (np.concatenate([found[name][i] for name in "bc"], axis=-1) for i in (0, 2))
    second, second_energy = by_plain_sum(x, mass, other, 0.0)
    right = {"a": first[:, :37], "b": first[:, 37:] + second[:, :18], "c": second[:, 18:]}
    return right, first_energy + second_energy


def test_equals_a_plain_sum_over_the_groups_it_acts_on(stars):
    found = slopes(stars)
    right, total = by_groups(found)
    tolerance = 1e-13 if stars.plan.scene.precision == "double" else 2e-6
    for name in "abc":
        np.testing.assert_allclose(found[name][3], right[name], rtol=0, atol=tolerance * np.abs(right["a"]).max())
        np.testing.assert_array_equal(found[name][4], found[name][1])
    energy = sum(shares.sum() for shares in stars.coupled.potential_energies(0.0).values())
    assert energy == pytest.approx(total, rel=30 * tolerance)


@pytest.mark.parametrize(
    "number", [{"strength": -STRENGTH}, {"strength": 1.001 * STRENGTH}, {"softening": 1.01 * SOFTENING}, {"other": 0.5}]
)
def test_a_sum_with_one_number_wrong_does_not_match(stars, number):
    found = slopes(stars)
    wrong, _ = by_groups(found, **number)
    largest = max(np.abs(found[name][3] - wrong[name]).max() for name in "abc")
    assert largest > 1e-4 * np.abs(wrong["a"]).max()


def test_action_equals_reaction(stars):
    found = slopes(stars)
    force = np.concatenate([mass * a for _, _, mass, a, _ in found.values()], axis=1)
    x = np.concatenate([found[name][0] for name in "abc"], axis=1)
    rounding = 1e-15 if stars.plan.scene.precision == "double" else 1e-6
    assert np.abs(force.sum(axis=1)).max() <= 10 * rounding * np.abs(force).sum()
    assert np.abs(np.cross(x.T, force.T).sum(axis=0)).max() <= 10 * rounding * np.abs(force).sum()


def test_is_the_gradient_of_its_potential():
    stars = system(1, precision="double", particles=PARTICLES, forces=FORCES)
    start, found = stars.get_state(), slopes(stars)
    random = np.random.default_rng(5)
    energies = []
    direction = {name: random.normal(size=part[0].shape) for name, part in found.items()}
    nudge = np.concatenate([np.concatenate([d, 0 * d]).ravel() for d in direction.values()])
    for step in (1e-5, -1e-5):
        stars.set_state(start + step * nudge)
        energies.append(sum(shares.sum() for shares in stars.coupled.potential_energies(0.0).values()))
    work = sum((found[name][2] * found[name][3] * direction[name]).sum() for name in found)
    assert (energies[1] - energies[0]) / 2e-5 == pytest.approx(work, rel=1e-7)


def test_particles_at_the_same_place_do_not_act_on_each_other():
    pair = {"positions": [[1, 2, 3], [1, 2, 3], [2, 2, 3]], "masses": [5, 7, 1]}
    for softening in (0, 0.1):
        force = {"type": "attraction", "strength": 1, "softening": softening}
        stars = system(1, particles={"a": pair}, forces=[force])
        pull = stars.derivative(0.0).reshape(6, 3)[3]
        factor = (1 + softening**2) ** -1.5
        assert pull == pytest.approx([factor, factor, -12 * factor], rel=1e-6)


def test_masses_that_fall_into_each_other_stop_the_run_when_they_meet():
    """At t = π/4: each moves on an ellipse of no width, half a revolution of period π/√2 · √2/2."""
    pair = {"positions": [[-0.5, 0, 0], [0.5, 0, 0]]}
    stars = system(
        1,
        precision="double",
        particles={"a": pair},
        forces=[{"type": "attraction", "strength": 1}],
        integrator={"type": "dop853", "tolerance": 1e-10},
    )
    with pytest.raises(SimulationError, match=r"at t = 0\.78539816\d* s .*softening"):
        stars.advance(1.0)


def test_what_cannot_go_together_is_refused():
    from particlecli.scene.checks import problems

    parts = {"forces": [{"type": "attraction"}], "integrator": {"type": "radau_iia"}}
    dropping = {"positions": [[0, 0, 0]], "dies": {"non_finite": True}}
    found = dict(problems(scene(particles={"a": dropping}, **parts)))
    assert "cannot advance particles that act on each other" in found["integrator", "type"]
    assert "within the same step" in found["particles", "a", "dies", "non_finite"]

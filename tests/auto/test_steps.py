"""Pilots step as the engine does: the same tableaux, the same order, the same impacts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from particlecli import runtime
from particlecli.auto.pilot import Pilot
from particlecli.auto.steps import Motion, Sampled, implicit_step
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import AdaptiveRungeKutta, ClosedForm, ImplicitRungeKutta
from tests.dynamics.scenes import body, system

IMPLICIT = [name for name, scheme in SCHEMES.items() if isinstance(scheme, ImplicitRungeKutta)]
FLOWN = [name for name, each in SCHEMES.items() if not isinstance(each, ImplicitRungeKutta | ClosedForm)]
ADAPTIVE = [name for name, scheme in SCHEMES.items() if isinstance(scheme, AdaptiveRungeKutta)]


def pilot_of(interval, **parts):
    """A pilot of the only group of a scene, for frames of another length."""
    from particlecli.dynamics.flights import Flights

    made = system(**parts)
    (plan,) = made.plan.groups
    flights = Flights(made.groups[plan.name].motion, made.plan.scene.precision, 40)
    return Pilot(plan, flights, interval, made.plan.scene.duration)


@pytest.fixture(scope="module")
def swing():
    """Two pendulums along x, driven oscillators along y, for a second."""
    return pilot_of(
        0.5,
        precision="double",
        particles={
            "bobs": {
                "positions": [[0.5, 0.2, 0], [1.0, -0.3, 0]],
                "velocities": [[0, 1, 0], [0.4, 0, 0]],
                "masses": [1, 2],
            }
        },
        forces=[{"type": "force_field", "force": ["-sin(x)", "-4*y + cos(t)", "0"]}],
    )


@pytest.mark.parametrize("scheme", FLOWN)
def test_flights_converge_with_the_order_of_the_scheme(swing, scheme):
    order = SCHEMES[scheme].order
    steps = {1: 128, 2: 32, 3: 16}.get(order, 4 if order < 8 else 1)
    exact = swing.fly(SCHEMES["dop853"], steps=64).positions
    errors = [np.abs(swing.fly(SCHEMES[scheme], steps=n).positions - exact)[-1].max() for n in (steps, 2 * steps)]
    # Of order 8, steps that are short enough for the asymptotic range err by no more than rounding.
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.4 if order < 8 else 1.7)


@pytest.mark.parametrize("scheme", ADAPTIVE)
def test_adaptive_flights_are_as_accurate_as_is_tolerated(swing, scheme):
    exact = swing.fly(SCHEMES["dop853"], steps=64).positions
    loose, tight = (swing.fly(SCHEMES[scheme], tolerance=tolerance) for tolerance in (1e-4, 1e-10))
    assert np.abs(loose.positions - exact).max() < 1e-3
    assert np.abs(tight.positions - exact).max() < 1e-8
    assert tight.evaluations > loose.evaluations >= SCHEMES[scheme].evaluations


def test_flights_bounce_at_the_instants_of_impacts():
    restitution, g, height = 0.5, 9.80665, 1.0
    ball = pilot_of(
        0.05,
        precision="double",
        particles={"ball": body((0, height, 0), (1, 0, 0))},
        forces=[{"type": "gravity"}],
        planes=[{"normal": [0, 1, 0], "restitution": restitution, "friction": 0.1}],
    )
    x, y, _ = ball.fly(SCHEMES["rk4"], steps=1).positions[:, 0].T
    times = 0.05 * np.arange(1, len(y) + 1)
    down, speed = math.sqrt(2 * height / g), math.sqrt(2 * g * height)
    after = times - down
    once = (after > 0) & (after < 2 * restitution * speed / g)
    np.testing.assert_allclose(y[once], restitution * speed * after[once] - g / 2 * after[once] ** 2, atol=1e-6)
    left = 1 - 0.1 * (1 + restitution) * speed  # Coulomb's impulse takes this from the speed along the plane
    np.testing.assert_allclose(x[once], down + max(0.0, left) * after[once], atol=1e-6)
    assert (y > -1e-12).all()


@pytest.mark.parametrize("on_hit", ["stick", "die"])
def test_flights_end_on_planes_that_hold(on_hit):
    stone = pilot_of(
        0.1,
        particles={"stone": body((0, 0.3, 0), (2, 0, 0))},
        forces=[{"type": "gravity"}],
        planes=[{"normal": [0, 1, 0], "on_hit": on_hit}],
    )
    positions = stone.fly(SCHEMES["rk4"], steps=2).positions[:, 0]
    assert positions[-1, 1] == pytest.approx(0, abs=1e-6)
    np.testing.assert_array_equal(positions[-1], positions[-2])
    assert positions[-1, 0] == pytest.approx(2 * math.sqrt(2 * 0.3 / 9.80665), abs=1e-3)


def test_flights_end_outside_of_the_box():
    runtime.start("single", 1)
    mist = pilot_of(
        0.1,
        flows={"wind": [{"type": "uniform", "velocity": [1, 0, 0]}]},
        emitters={
            "mist": {
                "motion": "first_order",
                "flow": "wind",
                "rate": 20,
                "dies": {"outside": {"min": [-1, -1, -1], "max": [0.25, 1, 1]}},
            }
        },
    )
    x = mist.fly(SCHEMES["euler"], steps=1).positions[:, 0, 0]
    np.testing.assert_allclose(x[:3], [0.1, 0.2, 0.3], rtol=1e-6)
    assert np.isnan(x[3:]).all()


def slopes(states, times, weights):
    """A pendulum along x, a driven oscillator along y, rest along z."""
    x, y, z, u, v, w = states
    return np.stack([u, v, w, -np.sin(x), -4 * y + weights * np.cos(times), 0 * z])


def jacobian(states, times, weights):
    matrices = np.zeros((2, states.shape[1], 3, 3))
    matrices[0, :, 0, 0], matrices[0, :, 1, 1] = -np.cos(states[0]), -4
    return matrices


def stepped(scheme, lengths, count):
    states = np.array([[0.5, 1.0], [0.2, -0.3], [0, 0], [0, 0.4], [1, 0], [0, 0]], dtype=float)
    sample, h = Sampled(states, np.array([0.0, 0.7]), np.array([1.0, 0.5])), np.asarray(lengths) / count
    for _ in range(count):
        new = implicit_step(SCHEMES[scheme], Motion(slopes, jacobian), sample, h)
        sample = Sampled(new, sample.times + h, sample.weights)
    return sample.states


@pytest.mark.parametrize("scheme", IMPLICIT)
def test_implicit_pilots_converge_with_the_order_of_the_scheme(scheme):
    order = SCHEMES[scheme].order
    steps = {1: 256, 2: 64}.get(order, 8)
    exact = stepped("radau_iia", [1.0, 1.0], 128)
    errors = [np.abs(stepped(scheme, [1.0, 1.0], n) - exact).max() for n in (steps, 2 * steps)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.35)


def test_particles_may_step_by_lengths_of_their_own():
    both = stepped("implicit_midpoint", [0.1, 0.2], 1)
    for i, h in enumerate((0.1, 0.2)):
        np.testing.assert_allclose(both[:, i], stepped("implicit_midpoint", [h, h], 1)[:, i], rtol=1e-13)


def test_closed_forms_are_not_flown(swing):
    with pytest.raises(ValueError, match="needs no pilot"):
        swing.fly(SCHEMES["exact"])

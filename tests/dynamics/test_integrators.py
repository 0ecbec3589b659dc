"""Every scheme has the order it declares, with and without explicit time, and no wrong entry goes unnoticed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import (
    AdaptiveRungeKutta,
    ClosedForm,
    ImplicitRungeKutta,
    Splitting,
)
from particlecli.dynamics.integrators.steppers import stepper
from particlecli.dynamics.memory import FieldMemory
from tests.cases import later
from tests.dynamics.scenes import body, system
from tests.dynamics.wrong_schemes import wrong_schemes

ASYMPTOTIC = {
    1: (1.0, (64, 128, 256, 512)),
    2: (1.0, (16, 32, 64, 128)),
    3: (1.0, (16, 32, 64, 128)),
    4: (1.0, (16, 32, 64, 128)),
    5: (4.0, (64, 96, 128, 192)),
    8: (1.0, (2, 3, 4, 6)),
}
"""For each order a time, s, and numbers of steps in which the error is neither coarse nor roundoff."""
COMPOSED = (4.0, (12, 16, 24, 32))

POSITION_FORCE = ["-4*x + 0.3*y*y + sin(3*t)", "-3*y - 0.5*x*z", "-2*z + 0.2*x + cos(2*t)"]
VELOCITY_FORCE = ["-4*x + 0.5*v*w + sin(3*t)", "-3*y - 0.7*v + 0.2*u*u", "-2*z + 0.3*x*w"]
FLOW = ["-y + 0.3*sin(2*t)*z", "x - 0.2*y*z", "0.5*cos(3*t) - 0.4*z*x"]
START = np.array([1.0, 0.5, -0.3, 0.2, -0.6, 0.8])


def newtonian(force, scheme):
    return system(
        precision="double",
        particles={"a": body(tuple(START[:3]), tuple(START[3:]))},
        forces=[{"type": "force_field", "force": force}],
        integrator=integrator(scheme),
    )


def integrator(scheme):
    """The scheme; an adaptive one with a tolerance so large that nothing but the longest step limits it."""
    return {"type": scheme} | ({"tolerance": 1e9} if isinstance(SCHEMES[scheme], AdaptiveRungeKutta) else {})


def first_order(scheme):
    return system(
        precision="double",
        flows={"f": [{"type": "expression", "velocity": FLOW}]},
        particles={"a": {"positions": [tuple(START[:3])], "motion": "first_order", "flow": "f"}},
        integrator=integrator(scheme),
    )


def exact(made, duration):
    made.set_state(START[: made.dim])

    def slope(t, y):
        made.set_state(y)
        return made.derivative(t)

    return solve_ivp(slope, (0, duration), START[: made.dim], method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]


def measured_order(made, duration, steps):
    truth = exact(made, duration)
    group = made.groups["a"]
    errors = []
    for count in steps:
        made.set_state(START[: made.dim])
        if group.has("pace"):
            group.plan = replace(group.plan, longest_step=duration / count)
            group.state.overwrite(("pace",), np.array([[duration]]))
        group.advance(0.0, duration, count)
        errors.append(np.abs(made.get_state() - truth).max())
    return -np.polyfit(np.log(steps), np.log(errors), 1)[0]


def cases():
    for name, scheme in SCHEMES.items():
        if isinstance(scheme, ClosedForm):
            continue
        splits = isinstance(scheme, Splitting)
        yield pytest.param(name, "position", marks=[] if splits else [pytest.mark.slow])
        if not splits:
            yield pytest.param(name, "velocity")
            yield pytest.param(name, "first_order", marks=[] if name == "rk4" else [pytest.mark.slow])


@pytest.mark.parametrize(("name", "problem"), list(cases()))
def test_measured_order_is_the_declared_one(name, problem):
    made = (
        first_order(name)
        if problem == "first_order"
        else newtonian(POSITION_FORCE if problem == "position" else VELOCITY_FORCE, name)
    )
    declared = SCHEMES[name].order
    duration, steps = COMPOSED if name == "composition8" else ASYMPTOTIC[declared]
    assert measured_order(made, duration, steps) == pytest.approx(declared, abs=0.2)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "wrong"), wrong_schemes())
def test_a_wrong_coefficient_lowers_the_order(name, wrong):
    made = newtonian(POSITION_FORCE, name)
    group = made.groups["a"]
    memory = FieldMemory()
    group.march.stepper = stepper(wrong, group.motion, group.real, memory)
    memory.open()
    if group.has("pace"):
        group.lanes.paced.stepper = group.march.stepper
    duration, steps = COMPOSED if name == "composition8" else ASYMPTOTIC[SCHEMES[name].order]
    finer = tuple(4 * count for count in steps)
    assert measured_order(made, duration, finer) < SCHEMES[name].order - 0.2


def test_evaluations_and_symmetry_are_declared_as_they_are():
    assert {name: scheme.evaluations for name, scheme in SCHEMES.items()} == {
        "euler": 1,
        "midpoint": 2,
        "rk3": 3,
        "rk4": 4,
        "symplectic_euler": 1,
        "velocity_verlet": 2,
        "yoshida4": 4,
        "composition8": 16,
        "dormand_prince": 7,
        "dop853": 12,
        "implicit_euler": 3,
        "implicit_midpoint": 3,
        "trapezoidal": 4,
        "tr_bdf2": 7,
        "radau_iia": 9,
        "exact": 1,
    }
    assert SCHEMES["velocity_verlet"].reversible
    assert not SCHEMES["symplectic_euler"].reversible
    of_implicit = {
        name: (scheme.symplectic, scheme.reversible, scheme.l_stable)
        for name, scheme in SCHEMES.items()
        if isinstance(scheme, ImplicitRungeKutta)
    }
    assert of_implicit == {
        "implicit_euler": (False, False, True),
        "implicit_midpoint": (True, True, False),
        "trapezoidal": (False, True, False),
        "tr_bdf2": (False, False, True),
        "radau_iia": (False, False, True),
    }


SYMPLECTIC = {name for name, scheme in SCHEMES.items() if scheme.symplectic}
ONES = ["velocity_verlet", "yoshida4", "implicit_midpoint"]


@pytest.mark.parametrize("name", [*ONES, *later(*sorted(SYMPLECTIC - set(ONES)))])
def test_symplectic_schemes_keep_the_energy_of_an_oscillator_bounded(name):
    made = system(
        precision="double",
        particles={"a": body((1.0, 0.0, 0.0), (0.0, 0.0, 0.0))},
        forces=[{"type": "force_field", "force": ["-x", 0, 0]}],
        integrator={"type": name},
    )
    worst = []
    for _ in range(40):
        made.groups["a"].advance(0.0, 50.0, 500)
        x, _, _, u, _, _ = made.get_state()
        worst.append(abs(0.5 * (x * x + u * u) - 0.5))
    assert max(worst) < 0.03
    assert np.polyfit(np.arange(40), worst, 1)[0] * 40 < 0.01


def kepler(tolerance, scheme):
    """Position after two thirds of a turn of an orbit of eccentricity 0.9, DETEST D5."""
    made = system(
        precision="double",
        particles={"a": body((0.1, 0.0, 0.0), (0.0, 19**0.5, 0.0))},
        forces=[{"type": "point_gravity", "strength": 1.0}],
        integrator={"type": scheme, "tolerance": tolerance},
    )
    for frame in range(1, 11):
        made.advance(2.0 * frame)
    return made.get_state()[:2], made.evaluations


@pytest.mark.parametrize("scheme", ["dormand_prince", *later("dop853")])
def test_adaptive_schemes_keep_to_their_tolerance(scheme):
    truth = np.array([-1.295266250987574, 0.4003938963792321])
    errors, evaluations = zip(
        *(
            (np.abs(found - truth).max(), count)
            for found, count in (kepler(tolerance, scheme) for tolerance in (1e-6, 1e-8, 1e-10))
        ),
        strict=True,
    )
    slope = np.polyfit(np.log10([1e-6, 1e-8, 1e-10]), np.log10(errors), 1)[0]
    assert slope == pytest.approx(1.0, abs=0.35)
    assert errors[2] < 1e-7
    assert list(evaluations) == sorted(evaluations)


def test_dop853_reaches_ten_digits_on_a_close_approach():
    found, _ = kepler(1e-13, "dop853")
    np.testing.assert_allclose(found, [-1.295266250987574, 0.4003938963792321], atol=1e-10)

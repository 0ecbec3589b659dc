"""Implicit schemes on stiff problems: their growth factors, Newton's method, contact, and births within a step."""

import math

import numpy as np
import pytest

from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import ImplicitRungeKutta
from particlecli.dynamics.integrators.steppers import stepper
from particlecli.dynamics.memory import FieldMemory
from tests.dynamics.scenes import body, scene, system

IMPLICIT = [name for name, scheme in SCHEMES.items() if isinstance(scheme, ImplicitRungeKutta)]
QUICK = ("implicit_euler", "radau_iia")
SPRING_PENDULUM = [
    {"type": "gravity", "acceleration": [0, -1, 0]},
    {"type": "force_field", "potential": "0.5e6*(sqrt(x**2 + y**2 + z**2) - 1)**2"},
]
SWUNG = (-0.8115763726510993, -0.5842493447457128)
"""Where the spring pendulum is after 10 s."""


def slow_unless_quick(names, quick=QUICK):
    return [pytest.param(n, marks=[] if n in quick else [pytest.mark.slow]) for n in names]


def radau_growth(z):
    return (1 + 2 * z / 5 + z**2 / 20) / (1 - 3 * z / 5 + 3 * z**2 / 20 - z**3 / 60)


def tr_bdf2_growth(z):
    return (1 + (math.sqrt(2) - 1) * z) / (1 - (1 - math.sqrt(0.5)) * z) ** 2


GROWTH = {
    "implicit_euler": lambda z: 1 / (1 - z),
    "implicit_midpoint": lambda z: (1 + z / 2) / (1 - z / 2),
    "trapezoidal": lambda z: (1 + z / 2) / (1 - z / 2),
    "tr_bdf2": tr_bdf2_growth,
    "radau_iia": radau_growth,
}
"""Growth of a mode of rate α in a step of h, by z = hα (Hairer & Wanner, IV.3)."""

MASSES = np.geomspace(1e-6, 1e2, 25)


@pytest.fixture(scope="module", params=slow_unless_quick(IMPLICIT))
def one_step(request):
    """A scheme, and what one step of 1 s makes of an oscillation along x and a decay along y, for all masses.

    The oscillation as x + iu/ω, the decay as v; both begin with 1.
    """
    made = system(
        precision="double",
        particles={
            "a": {
                "positions": [[1.0, 0.0, 0.0]] * len(MASSES),
                "velocities": [[0.0, 1.0, 0.0]] * len(MASSES),
                "masses": MASSES.tolist(),
            }
        },
        forces=[{"type": "force_field", "force": ["-x", "-v", 0]}],
        integrator={"type": request.param},
    )
    made.groups["a"].advance(0.0, 1.0, 1)
    x, _, _, u, v, _ = made.get_state().reshape(6, -1)
    return request.param, x + 1j * u * np.sqrt(MASSES), v


def test_oscillations_grow_as_the_stability_function_says(one_step):
    name, found, _ = one_step
    # x + iu/ω turns as exp(−iωt).
    np.testing.assert_allclose(found, GROWTH[name](-1j / np.sqrt(MASSES)), atol=1e-11)
    assert np.abs(found - GROWTH[name](-1.001j / np.sqrt(MASSES))).max() > 1e-5


def test_decays_shrink_as_the_stability_function_says(one_step):
    name, _, found = one_step
    rounding = 1e-16 / MASSES  # of a slope of 1/m, which an explicit stage adds as it is
    assert (np.abs(found - GROWTH[name](-1 / MASSES)) <= 1e-12 * np.abs(found) + 1e-15 + rounding).all()
    assert (np.abs(found) < 1).all()


def test_l_stable_schemes_damp_fast_decay_and_overshoot_little_or_not_at_all(one_step):
    name, _, found = one_step
    at_thousand = found[np.argmin(np.abs(1 / MASSES - 1000))]
    if SCHEMES[name].l_stable:
        assert found.min() >= (-0.21 if name == "tr_bdf2" else 0)
        assert abs(at_thousand) < 0.005
    else:
        assert at_thousand < -0.99


def swung(scheme, steps, precision="double"):
    made = system(
        precision=precision,
        particles={"a": body((1.0, 0.0, 0.0), (0.0, 0.0, 0.0))},
        forces=SPRING_PENDULUM,
        integrator={"type": scheme},
    )
    outcome = made.groups["a"].advance(0.0, 10.0, steps)
    return made, outcome


@pytest.mark.parametrize(
    ("scheme", "steps", "tolerance"),
    [
        ("radau_iia", 100, 2e-6),
        pytest.param("implicit_midpoint", 200, 0.01, marks=pytest.mark.slow),
        pytest.param("trapezoidal", 400, 0.01, marks=pytest.mark.slow),
        pytest.param("tr_bdf2", 400, 0.01, marks=pytest.mark.slow),
    ],
)
def test_the_slow_swing_of_a_stiff_pendulum_is_right_far_past_the_explicit_limit(scheme, steps, tolerance):
    made, outcome = swung(scheme, steps)
    assert outcome.failed_slot is None
    # An explicit scheme needs steps below 2.8/√k = 0.0028 s.
    np.testing.assert_allclose(made.get_state()[:2], SWUNG, atol=tolerance)


@pytest.mark.slow
def test_explicit_schemes_fail_there():
    assert swung("rk4", 1000)[1].failed_slot == 0


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["implicit_midpoint", "radau_iia"])
def test_the_stiff_pendulum_swings_in_single_precision(scheme):
    made, outcome = swung(scheme, 400, "single")
    assert outcome.failed_slot is None
    np.testing.assert_allclose(made.get_state()[:2], SWUNG, atol=5e-3)


class WithWrongJacobian:
    """Equations of motion whose Jacobian is multiplied by a factor."""

    def __init__(self, motion, factor):
        self.motion, self.factor = motion, factor
        self.first_order = motion.first_order
        self.derivative = motion.derivative

    def jacobian(self, *arguments):
        return tuple(
            tuple(tuple(self.factor * entry for entry in row) for row in matrix)
            for matrix in self.motion.jacobian(*arguments)
        )


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "converges"), [(1.0, True), (-1.0, False), (0.5, False)])
def test_newton_needs_the_right_jacobian(factor, converges):
    made = system(
        precision="double",
        particles={"a": body((1.0, 0.0, 0.0), (0.0, 0.0, 0.0))},
        forces=SPRING_PENDULUM,
        integrator={"type": "implicit_midpoint"},
    )
    group = made.groups["a"]
    memory, motion = FieldMemory(), WithWrongJacobian(group.motion, factor)
    group.march.stepper = stepper(SCHEMES["implicit_midpoint"], motion, group.real, memory)
    memory.open()
    assert (group.advance(0.0, 1.0, 50).failed_slot is None) == converges


def test_an_equation_without_a_solution_fails_for_that_particle():
    made = system(
        precision="double",
        particles={"a": {"positions": [[0.1, 0, 0], [1, 0, 0]], "velocities": [[0, 0, 0], [0, 0, 0]]}},
        forces=[{"type": "force_field", "force": ["x*x", 0, 0]}],
        integrator={"type": "implicit_euler"},
    )
    # x = x₀ + h²x² has a solution only where 4h²x₀ <= 1.
    assert made.groups["a"].advance(0.0, 1.0, 1).failed_slot == 1


@pytest.mark.parametrize("scheme", slow_unless_quick(IMPLICIT, quick=("radau_iia",)))
def test_particles_born_within_a_step_take_what_is_left_of_it(scheme):
    from particlecli.simulate import Simulation

    described = scene(
        precision="double",
        fps=2,
        emitters={"sparks": {"rate": 40, "lifetime": 5, "speed": 2, "direction": {"axis": [0, 1, 0]}}},
        forces=[{"type": "gravity", "acceleration": [0, -10, 0]}],
        integrator={"type": scheme, "dt": 0.5},
    )
    group = list(Simulation(described))[-1].groups["sparks"]
    age = group.ages
    fallen = 5 * age**2
    if scheme == "implicit_euler":
        # In steps of the whole 0.5 s after a first part: x falls 10 h² too deep by half in each.
        part = np.mod(age, 0.5)
        whole = np.round((age - part) / 0.5)
        fallen = fallen + 5 * (part**2 + whole * 0.25)
    assert len(age) == 40
    np.testing.assert_allclose(group.positions[:, 1], 2 * age - fallen, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", IMPLICIT)
def test_friction_holds_and_slides_with_implicit_schemes(scheme):
    a = np.radians(30)
    normal = (float(-np.sin(a)), float(np.cos(a)), 0.0)
    masses = [1.0, 1.0]
    for friction, moved in (({"coulomb": 0.2}, 3.205858157774931 / 2), ({"coulomb": 0.6}, 0.0)):
        made = system(
            precision="double",
            particles={"a": {**body((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), "masses": masses[:1]}},
            forces=[{"type": "gravity", "acceleration": [0, -9.81, 0]}],
            planes=[{"normal": normal, "friction": friction}],
            integrator={"type": scheme, "dt": 0.01},
        )
        for frame in range(1, 11):
            made.advance(frame / 10)
        tolerance = 0.02 if scheme == "implicit_euler" else 1e-12
        assert np.hypot(*made.get_state()[:2]) == pytest.approx(moved, abs=tolerance)


@pytest.mark.slow
def test_implicit_schemes_bear_viscous_friction_that_is_stiff():
    made = system(
        precision="double",
        particles={"a": body((0.0, 0.0, 0.0), (5.0, 0.0, 1.0))},
        forces=[{"type": "gravity", "acceleration": [0, -9.81, 0]}],
        planes=[{"friction": {"viscous": 50.0}}],
        integrator={"type": "radau_iia", "dt": 0.1},
    )
    made.advance(0.1)
    x, _, z, u, _, w = made.get_state()
    # The speed falls as exp(−k g t), in one step to the share that the stability function tells.
    rate = 50 * 9.81
    np.testing.assert_allclose([x, z], np.array([5, 1]) * (1 - radau_growth(-0.1 * rate)) / rate, rtol=1e-9)
    assert abs(u) < 1
    assert abs(w) < 0.2


@pytest.mark.slow
def test_implicit_schemes_lift_off_where_a_spring_pulls_away_from_a_plane():
    made = system(
        precision="double",
        particles={"a": body((1.0, 0.1, 0.0), (0.0, 0.0, 0.0))},
        forces=[
            {"type": "gravity", "acceleration": [0, -9.81, 0]},
            {"type": "force_field", "potential": "0.5e4*(x + y)**2"},
        ],
        planes=[{"point": [0, 0.1, 0], "friction": 0.3}],
        integrator={"type": "implicit_euler", "dt": 0.01},
    )
    for frame in range(1, 11):
        made.advance(frame / 10)
    x, y = made.get_state()[:2]
    assert y > 1
    assert x + y == pytest.approx(0, abs=0.01)

"""Implicit steps of coupled particles: their order, stiffness far beyond explicit steps, solves that fail."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from particlecli import cores
from particlecli.dynamics.coupled import newton, team
from particlecli.errors import SimulationError
from tests.benchmarks import cloth as fine
from tests.dynamics.scenes import system

CLOTH = {
    "layout": {"type": "grid", "counts": [9, 1, 9], "spacing": 0.1},
    "mass": 0.01,
    "pins": [{"where": "(x < -0.39)*(abs(z) > 0.39)"}],
}


def cloth(scheme, stiffness, threads=2, counts=9, **more):
    """A system that takes one step in each call of `advance`, however long."""
    springs = {"type": "springs", "stiffness": stiffness, "damping": more.pop("damping", 0.0)}
    layout = {**CLOTH["layout"], "counts": [counts, 1, counts]}
    return system(
        threads,
        fps=1000,
        particles={"cloth": {**CLOTH, "layout": layout}},
        forces=[{"type": "gravity"}, springs, {"type": "drag", "coefficient": 0.002}],
        integrator={"type": scheme, "dt": 1 / 1000},
        **more,
    )


def end(found, steps, duration=0.5):
    """Positions after so many equal steps, one component after the other."""
    found.restart()
    for s in range(steps):
        found.advance(duration * (s + 1) / steps)
    return found.get_state()[: found.dim // 2]


def by_scipy(found, duration=0.5):
    def slope(time, state):
        found.set_state(state)
        return found.derivative(time)

    found.restart()
    solution = solve_ivp(slope, (0, duration), found.get_state(), method="DOP853", rtol=1e-9, atol=1e-9)
    return solution.y[: found.dim // 2, -1]


@pytest.fixture(scope="module")
def slack():
    return cloth("tr_bdf2", 20, damping=0.02, precision="double")


def measured_order(found, counts=(40, 60, 90, 120)):
    right = by_scipy(found)
    errors = [np.abs(end(found, steps) - right).max() for steps in counts]
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0]


def test_errors_fall_with_the_order_of_the_scheme(slack):
    assert measured_order(slack) == pytest.approx(2, abs=0.2)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scheme", "order", "counts"),
    [
        ("implicit_euler", 1, (240, 400, 600, 800)),
        ("implicit_midpoint", 2, (40, 60, 90, 120)),
        ("trapezoidal", 2, (40, 60, 90, 120)),
    ],
)
def test_other_schemes_have_their_order_too(scheme, order, counts):
    found = cloth(scheme, 20, damping=0.02, precision="double")
    assert measured_order(found, counts) == pytest.approx(order, abs=0.2)


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "order"), [("implicit_euler", 1), ("implicit_midpoint", 2), ("tr_bdf2", 2)])
def test_forces_that_do_not_tell_how_they_change_are_solved_for_as_well(scheme, order):
    """Two stars that go around each other in 2 s, at a distance of 1 m."""
    speed = 0.5 * math.pi
    stars = {"mass": 0.5, "positions": [[0.5, 0, 0], [-0.5, 0, 0]], "velocities": [[0, speed, 0], [0, -speed, 0]]}
    found = system(
        2,
        fps=1000,
        particles={"stars": stars},
        forces=[{"type": "attraction", "strength": math.pi**2, "softening": 0}],
        integrator={"type": scheme, "dt": 1 / 1000},
        precision="double",
    )
    counts = np.array([200, 300, 450, 600])
    ends = np.stack([end(found, steps) for steps in counts])
    errors = np.abs(ends - [0, 0, 0.5, -0.5, 0, 0]).max(axis=1)
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] == pytest.approx(order, abs=0.2)


def test_a_step_cut_in_two_arrives_all_the_same(slack, monkeypatch):
    whole = end(slack, 4, duration=0.1)
    monkeypatch.setattr(newton.Newton, "_solve", _refuse_long(newton.Newton._solve))
    np.testing.assert_allclose(end(slack, 1, duration=0.1), whole, atol=1e-7)


def _refuse_long(solve):
    def refusing(self, packs, start, now, h):
        self._left = 1.0
        found, evaluations = solve(self, packs, start, now, h)
        return found and h < 0.03, evaluations

    return refusing


def test_a_solve_that_fails_cuts_the_step_and_then_stops_the_run(slack, monkeypatch):
    monkeypatch.setattr(newton, "MOST_GRADIENTS", 1)
    monkeypatch.setattr(newton, "MOST_CUTS", 2)
    slack.restart()
    with pytest.raises(SimulationError, match=r"t = 0 s have no solution .* step of 0\.025 s"):
        slack.advance(0.1)


@pytest.fixture
def cooperation(monkeypatch):
    """Lets as many members as are asked for share the smallest system, whoever else wants the cores."""
    monkeypatch.setattr(team, "FEWEST", 1)
    monkeypatch.setattr(team, "INTERRUPTIONS", 10**9)

    def together(members):
        monkeypatch.setattr(cores, "usable", lambda: members)

    return together


@pytest.mark.skipif(not cores.known(), reason="nobody cooperates")
def test_same_bits_for_any_number_of_members(slack, cooperation):
    ends = []
    for members in (1, 2):
        cooperation(members)
        ends.append(end(slack, 20))
    np.testing.assert_array_equal(*ends)


def swung(threads):
    """The state and the energy, J, after each of 40 steps of 1/120 s.

    k = 4·10⁷ N/m on 10 g: the fastest mode has ω ≈ 2·10⁵ 1/s, ω dt ≈ 1900.
    """
    found = cloth("implicit_euler", 4e7, threads, counts=12)
    states, energies = [], []
    for step in range(40):
        found.advance((step + 1) / 120)
        states.append(found.get_state().reshape(6, -1))
        _, y, _, *velocity = states[-1]
        energies.append(0.01 * 9.80665 * y.sum() + 0.005 * np.square(velocity).sum())
    return np.stack(states), energies


@pytest.fixture(scope="module")
def stiff():
    return swung(threads=2)


def test_a_stiff_cloth_is_stable_far_beyond_the_explicit_limit(stiff):
    states, energies = stiff
    assert max(energies) <= 1e-3
    assert energies[-1] < -0.1
    assert np.abs(states[:, :3]).max() < 2.4


@pytest.mark.slow
def test_same_bits_for_any_number_of_threads(stiff, cooperation):
    for threads in (1, 3):
        cooperation(threads)
        np.testing.assert_array_equal(swung(threads)[0], stiff[0])


SPRING = {"type": "springs", "stiffness": 100, "pairs": [[0, 1]]}
SHORT = 1 / 50


@pytest.fixture(scope="module")
def hard():
    """Springs that are hard on Newton's method, one group each, and a force that grows without bound."""
    return system(
        2,
        fps=50,
        precision="double",
        particles={
            "unequal": {"positions": [[0, 0, 0], [1.1, 0, 0]], "masses": [1e6, 1]},
            "met": {"positions": [[1, 2, 3], [1, 2, 3]]},
            "slack": {"positions": [[0, 0, 0], [0.3, -0.4, 1.2]]},
            "runaway": {"positions": [[0, 0, 0], [0, 1, 0]]},
        },
        forces=[
            {**SPRING, "rest_length": 1, "on": ["unequal", "met", "runaway"]},
            {**SPRING, "rest_length": 0, "on": ["slack"]},
            {"type": "force_field", "force": ["x*x", 0, 0], "on": ["runaway"]},
        ],
        integrator={"type": "tr_bdf2", "dt": SHORT},
    )


def ends(found, name):
    """Where the two ends of the spring of a group are, after 50 steps."""
    found.restart()
    for step in range(50):
        found.advance((step + 1) * SHORT)
    return found.groups[name].state.read(("x", "y", "z")).astype(float).T


def grown(reduced):
    """The share of a stretch that 50 steps leave, by the stability function of tr_bdf2."""
    z = 1j * SHORT * math.sqrt(100 / reduced)
    return (((1 + (math.sqrt(2) - 1) * z) / (1 - (1 - math.sqrt(0.5)) * z) ** 2) ** 50).real


@pytest.mark.slow
def test_a_mass_on_one_a_million_times_heavier_swings_as_the_scheme_says(hard):
    heavy, light = ends(hard, "unequal")
    assert light[0] - heavy[0] == pytest.approx(1 + 0.1 * grown(1 / (1 + 1e-6)), abs=1e-8)
    assert 1e6 * heavy[0] + light[0] == pytest.approx(1.1, abs=1e-6)


@pytest.mark.slow
def test_a_spring_without_rest_length_passes_through_no_length(hard):
    one, other = ends(hard, "slack")
    np.testing.assert_allclose(other - one, np.array([0.3, -0.4, 1.2]) * grown(0.5), atol=1e-8)


@pytest.mark.slow
def test_ends_of_a_spring_at_the_same_place_stay_there(hard):
    np.testing.assert_array_equal(ends(hard, "met"), [[1, 2, 3], [1, 2, 3]])


@pytest.mark.slow
def test_equations_without_a_solution_stop_the_run_and_tell_how_far_they_are_from_one(hard):
    """x = x₀ + (γh)² x² has none where 4 (γh)² x₀ > 1."""
    hard.restart()
    hard.groups["runaway"].state.overwrite(("x",), np.array([[1e12, 0.0]]))
    with pytest.raises(SimulationError, match=r"no solution .* still change by [\d.e+]+ of themselves") as caught:
        hard.advance(SHORT)
    assert caught.value.exit_code == 3


ROUNDING = 2e-5
"""What rounding to single precision is worth in the energy of a fine cloth, J: ½ k (6e-8 m)² of each of 10⁵ springs is
9e-6 J before a step and after it."""


@pytest.mark.slow
def test_straight_strands_that_hardly_feel_a_turn_about_themselves_hang_in_single_precision():
    found = system(
        2,
        fps=120,
        particles={
            "hair": {
                "layout": {"type": "hair", "radius": 0.5, "strands": 100, "count": 20, "length": 0.75},
                "mass": 1e-3,
                "pins": [{"where": "s < 0.06"}],
            }
        },
        forces=[
            {"type": "gravity"},
            {"type": "springs", "stiffness": 40, "damping": 0.01, "links": ["structural"]},
            {"type": "springs", "stiffness": 3, "damping": 0.004, "links": ["bend"]},
        ],
        integrator={"type": "implicit_euler", "dt": 1 / 120},
        precision="single",
    )
    before = found.get_state().reshape(6, -1)[1].mean()
    for step in range(12):
        found.advance((step + 1) / 120)
    state = found.get_state().reshape(6, -1)
    assert np.isfinite(state).all()
    assert state[1].mean() < before


@pytest.mark.slow
def test_a_fine_stiff_cloth_gains_no_energy():
    """One swing of 128 × 128 particles, ω dt ≈ 2000: energy of motion, height and springs together, each step."""
    found = fine.cloth("implicit_euler", 1)
    energies = [0.0]
    for step in range(120):
        found.advance((step + 1) * fine.DT)
        energies.append(fine.energy(found.get_state().reshape(6, -1)))
    assert np.diff(energies).max() < ROUNDING
    assert max(energies[1:]) < 0.0
    assert np.diff(energies[30::30]).max() < 0.0
    assert energies[-1] < -0.1


@pytest.mark.slow
def test_a_fine_stiff_cloth_loses_what_the_scheme_takes_and_little_else():
    """The same cloth in double precision, which is solved for 300 times as accurately, loses as much in 50 steps."""
    lost = []
    for precision in ("single", "double"):
        found = fine.cloth("implicit_euler", 1, precision)
        for step in range(50):
            found.advance((step + 1) * fine.DT)
        lost.append(fine.energy(found.get_state().reshape(6, -1)))
    assert lost[0] == pytest.approx(lost[1], rel=0.1)

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from particlecli.dynamics.integrators import SCHEMES
from particlecli.stability.growth import longest_stable_steps, stability_limit
from particlecli.stability.modes import Modes, describe, kinds_of, modes_of

NOTHING = np.zeros((1, 3, 3))

MATRICES = arrays(np.float64, (2, 3, 3), elements=st.floats(-5, 5).map(lambda x: round(x, 2)))


def ordered(values):
    return sorted(np.ravel(values), key=lambda z: (round(z.real, 6), z.imag))


@pytest.mark.parametrize("stiffness", [1e-6, 4.0, 1e10])
@pytest.mark.parametrize("ratio", [0.0, 0.3, 3.0])
def test_a_damped_spring_has_its_two_rates(stiffness, ratio):
    omega = np.sqrt(stiffness)
    modes = modes_of(-stiffness * np.eye(3)[None], -2 * ratio * omega * np.eye(3)[None])
    root = np.sqrt(complex(ratio**2 - 1))
    expected = [omega * (-ratio + sign * root) for sign in (1, -1)] * 3
    assert ordered(modes.rates / omega) == pytest.approx(ordered(np.array(expected) / omega))
    assert modes.stiffness == pytest.approx(np.full((1, 6), stiffness))
    assert modes.damping == pytest.approx(np.full((1, 6), 2 * ratio * omega), abs=1e-9 * omega)


def test_drag_slows_velocities_and_leaves_positions_free():
    modes = modes_of(NOTHING, -3.0 * np.eye(3)[None])
    assert ordered(modes.rates) == pytest.approx([-3, -3, -3, 0, 0, 0])


def test_a_magnetic_field_turns_velocities():
    field = np.cross(np.eye(3), [0.0, 0.0, 2.0])
    modes = modes_of(NOTHING, field[None])
    assert ordered(modes.rates) == pytest.approx([-2j, 0, 0, 0, 0, 2j])
    assert modes.damping[modes.rates != 0] == pytest.approx(-modes.rates[modes.rates != 0])


def test_a_point_mass_pulls_together_across_and_apart_along():
    """∂a/∂x of −GM x/r³ at distance 1 is −GM (1 − 3 n nᵀ): two oscillations and a saddle."""
    tide = 3.0 * np.diag([1.0, 0.0, 0.0]) - np.eye(3)
    modes = modes_of(tide[None], NOTHING)
    root = np.sqrt(2)
    assert ordered(modes.rates) == pytest.approx(ordered([1j, -1j, 1j, -1j, root, -root]))
    assert kinds_of(modes.rates[0]).tolist().count("growth") == 1


def test_first_order_motion_has_the_rates_of_its_gradient():
    gradient = np.array([[[0.0, -2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, -1.0]]])
    modes = modes_of(gradient)
    assert modes.rates.shape == (1, 3)
    assert ordered(modes.rates) == pytest.approx([-1, -2j, 2j])
    assert modes.partners == pytest.approx(np.zeros((1, 3)))


@given(MATRICES)
def test_rates_are_eigenvalues_and_solve_the_equations_of_their_oscillators(matrices):
    J, G = matrices
    modes = modes_of(J[None], G[None])
    rates = np.linalg.eigvals(np.block([[np.zeros((3, 3)), np.eye(3)], [J, G]]))
    size = 1.0 + np.abs(rates).max()
    apart = np.abs(modes.rates[0][:, None] - rates[None, :])
    assert apart.min(axis=0).max() < 1e-3 * size  # an eigenvalue of a defective matrix is known to a root of rounding
    assert apart.min(axis=1).max() < 1e-3 * size
    a, d, k = (part[0] for part in (modes.rates, modes.damping, modes.stiffness))
    assert np.abs(a**2 + d * a + k).max() < 1e-3 * size**2


def test_wrong_sign_or_half_a_coefficient_shows():
    right = modes_of(-4.0 * np.eye(3)[None], NOTHING).rates
    for wrong in (4.0, -2.0):
        assert ordered(modes_of(wrong * np.eye(3)[None], NOTHING).rates) != pytest.approx(ordered(right), rel=0.1)


def test_kinds():
    rates = np.array([0, 5j, -1 + 5j, -5 + 1j, -3, 3, 1 + 5j, 0.001 + 5j])
    assert kinds_of(rates).tolist() == [
        "free",
        "oscillation",
        "oscillation",
        "decay",
        "decay",
        "growth",
        "growth",
        "oscillation",
    ]
    assert describe(3.0j) == "an oscillation of 0.477 Hz"
    assert describe(-1000 + 0j) == "a decay at 1e+03 1/s"


@pytest.mark.parametrize("seed", [0, 72])
@pytest.mark.parametrize("scheme", ["rk4", "symplectic_euler"])
def test_the_limit_of_distinct_modes_is_that_of_all(seed, scheme):
    random = np.random.default_rng(seed)
    damping = random.normal(size=(10, 3, 3)) - 5 * np.eye(3)
    modes = modes_of(random.normal(size=(10, 3, 3)) * 5 - 9 * np.eye(3), damping).shaped(-1)
    limits = longest_stable_steps(SCHEMES[scheme], modes)
    step, rate = stability_limit(SCHEMES[scheme], modes)
    assert step == pytest.approx(limits.min(), rel=1e-6)
    assert 0.01 < step < 10
    assert limits[modes.rates == rate].min() == pytest.approx(step)


def test_conjugates_count_once_and_rest_not_at_all():
    modes = modes_of(np.diag([-1.0, -1.0, 0.0])[None], NOTHING).shaped(-1)
    assert len(modes.rates) == 6
    assert modes.distinct(paired=False).rates == pytest.approx([1j])


def test_around_are_sizes_and_directions_up_to_the_rate():
    modes = Modes.around(3.0, turning=False)
    assert np.abs(modes.rates).max() == pytest.approx(3.0)
    assert modes.rates.real.max() < 1e-9
    assert (modes.damping.imag == 0).all()
    assert (Modes.around(3.0, turning=True).damping.imag != 0).any()

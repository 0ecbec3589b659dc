from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import ImplicitRungeKutta, Splitting
from particlecli.dynamics.integrators.runge_kutta import RK4
from particlecli.dynamics.integrators.splitting import VELOCITY_VERLET
from particlecli.scene.load import load_scene
from particlecli.simulate import Simulation
from particlecli.stability.growth import excess, growth, longest_stable_steps, stability_function
from particlecli.stability.modes import Modes, modes_of


def oscillation(omega):
    return Modes.of_pairs(np.array([1j * omega]))


def decay(rate):
    return Modes.of_first_order(np.array([-rate + 0j]))


def limit(scheme, modes):
    """The longest stable step times the size of the rate."""
    return float((longest_stable_steps(scheme, modes) * np.abs(modes.rates)).min())


GROWTH_OF_OSCILLATION = {
    "euler": lambda q: math.sqrt(1 + q**2),
    "implicit_euler": lambda q: 1 / math.sqrt(1 + q**2),
    "midpoint": lambda q: math.sqrt(1 + q**4 / 4),
    "trapezoidal": lambda q: 1.0,
    "implicit_midpoint": lambda q: 1.0,
    "exact": lambda q: 1.0,
    "rk4": lambda q: math.sqrt((1 - q**2 / 2 + q**4 / 24) ** 2 + (q - q**3 / 6) ** 2),
    "velocity_verlet": lambda q: 1.0 if q <= 2 else q**2 / 2 - 1 + q * math.sqrt(q**2 / 4 - 1),
    "symplectic_euler": lambda q: 1.0 if q <= 2 else q**2 / 2 - 1 + q * math.sqrt(q**2 / 4 - 1),
}
"""A step's growth of x″ = −ω²x with q = ωh, in closed form."""


@pytest.mark.parametrize("scheme", GROWTH_OF_OSCILLATION)
@given(q=st.floats(0.01, 4.0).filter(lambda q: abs(q - 2) > 1e-3), omega=st.floats(1e-3, 1e3))
def test_growth_of_an_oscillation(scheme, q, omega):
    found = growth(SCHEMES[scheme], oscillation(omega), q / omega)
    assert found == pytest.approx(GROWTH_OF_OSCILLATION[scheme](q), rel=1e-9)


LIMITS = {  # of oscillations and of decays, in |hα|; 0: unstable at any step
    "euler": (0.0, 2.0),
    "midpoint": (0.0, 2.0),
    "rk3": (math.sqrt(3), 2.512745326618329),
    "rk4": (2 * math.sqrt(2), 2.785293563405282),
    "symplectic_euler": (2.0, 2.0),
    "velocity_verlet": (2.0, 4.0),
    "yoshida4": (1.5734019, 2.507777857),
    "dormand_prince": (None, 3.306567893),
    "implicit_euler": (math.inf, math.inf),
    "implicit_midpoint": (math.inf, math.inf),
    "trapezoidal": (math.inf, math.inf),
    "tr_bdf2": (math.inf, math.inf),
    "radau_iia": (math.inf, math.inf),
    "exact": (math.inf, math.inf),
}


@pytest.mark.parametrize("scheme", LIMITS)
@pytest.mark.parametrize("rate", [1e-3, 7.0, 1e5])
def test_limits_of_oscillation_and_decay(scheme, rate):
    of_oscillation, of_decay = LIMITS[scheme]
    if of_oscillation is not None:
        assert limit(SCHEMES[scheme], oscillation(rate)) == pytest.approx(of_oscillation, rel=1e-6)
    assert limit(SCHEMES[scheme], decay(rate)) == pytest.approx(of_decay, rel=1e-7)


@pytest.mark.parametrize("scheme", sorted(SCHEMES))
def test_every_scheme_is_stable_up_to_its_limit_and_not_beyond(scheme):
    modes = Modes.of_pairs(np.exp(1j * np.linspace(0.5, 1.0, 9) * np.pi)).joined(decay(1.0))
    limits = longest_stable_steps(SCHEMES[scheme], modes)
    some = (limits > 0) & np.isfinite(limits)
    inside = np.where(some, limits * 0.999, 1e-6)
    assert (excess(SCHEMES[scheme], modes, inside)[limits > 0] <= 1 + 1e-9).all()
    assert (excess(SCHEMES[scheme], modes, limits * 1.001)[some] > 1 + 1e-9).all()
    assert (excess(SCHEMES[scheme], modes, np.full(len(limits), 1e3))[np.isinf(limits)] <= 1 + 1e-9).all()


def test_wrong_entries_of_a_tableau_move_the_limit():
    halved = replace(RK4, a=((), (1 / 4,), (0.0, 1 / 2), (0.0, 0.0, 1.0)))
    swapped = replace(RK4, b=(1 / 3, 1 / 6, 1 / 3, 1 / 6))
    sign = replace(RK4, a=((), (1 / 2,), (0.0, -1 / 2), (0.0, 0.0, 1.0)))
    for wrong in (halved, swapped, sign):
        assert abs(limit(wrong, decay(1.0)) - 2.785293563405282) > 0.01
    late = Splitting(order=2, moves=(("kick", 0.5), ("drift", 1.0), ("kick", 0.6)))
    assert limit(late, oscillation(1.0)) != pytest.approx(limit(VELOCITY_VERLET, oscillation(1.0)), rel=1e-3)


ORDERS = {name: scheme for name, scheme in SCHEMES.items() if hasattr(scheme, "b")}


@pytest.mark.parametrize("name", ORDERS)
def test_stability_functions_agree_with_the_exponential_up_to_the_order(name):
    scheme = ORDERS[name]
    turns = np.exp(2j * np.pi * np.arange(64) / 64)
    taylor = np.fft.fft(stability_function(scheme, 0.25 * turns)) / 64 / 0.25 ** np.arange(64)
    exact = [1 / math.factorial(k) for k in range(scheme.order + 1)]
    assert taylor[: scheme.order + 1] == pytest.approx(exact, abs=1e-10)
    assert abs(taylor[scheme.order + 1] * math.factorial(scheme.order + 1) - 1) > 1e-3


RATIONAL = {
    "implicit_euler": lambda z: 1 / (1 - z),
    "implicit_midpoint": lambda z: (1 + z / 2) / (1 - z / 2),
    "trapezoidal": lambda z: (1 + z / 2) / (1 - z / 2),
    "tr_bdf2": lambda z: (1 + (math.sqrt(2) - 1) * z) / (1 - (1 - math.sqrt(0.5)) * z) ** 2,
    "radau_iia": lambda z: (1 + 2 * z / 5 + z**2 / 20) / (1 - 3 * z / 5 + 3 * z**2 / 20 - z**3 / 60),
}


@pytest.mark.parametrize("name", RATIONAL)
@given(x=st.floats(-50, 0), y=st.floats(-50, 50))
def test_implicit_schemes_are_their_rational_functions(name, x, y):
    found = stability_function(SCHEMES[name], np.array([x + 1j * y]))
    assert found == pytest.approx(RATIONAL[name](x + 1j * y), rel=1e-10)


def test_l_stable_schemes_forget_fast_decays_at_once():
    for name, scheme in SCHEMES.items():
        if isinstance(scheme, ImplicitRungeKutta):
            assert (growth(scheme, decay(1.0), 1e6)[0] < 1e-4) == scheme.l_stable, name


@given(
    share=st.floats(0.05, 3.0),
    damping=st.floats(0.0, 3.0),
    scheme=st.sampled_from(["symplectic_euler", "velocity_verlet", "yoshida4"]),
)
def test_splittings_act_on_damped_oscillators_as_written_out(share, damping, scheme):
    stiffness = 4.0
    step = share / math.sqrt(stiffness)
    columns = []
    for x, v in ((1.0, 0.0), (0.0, 1.0)):
        for move, part in SCHEMES[scheme].moves:
            if move == "drift":
                x += part * step * v
            else:
                v += part * step * (-stiffness * x - damping * v)
        columns.append((x, v))
    radius = np.abs(np.linalg.eigvals(np.array(columns).T)).max()
    root = np.sqrt(complex(damping**2 / 4 - stiffness))
    modes = Modes(
        np.array([-damping / 2 + root, -damping / 2 - root]), np.full(2, stiffness + 0j), np.full(2, damping + 0j)
    )
    assert growth(SCHEMES[scheme], modes, step) == pytest.approx([radius, radius], rel=1e-6, abs=1e-6)


def test_growth_of_the_motion_itself_limits_no_step():
    saddle = modes_of(np.diag([4.0, 4.0, 4.0])[None], np.zeros((1, 3, 3))).shaped(-1)
    assert sorted(saddle.rates.real) == pytest.approx([-2, -2, -2, 2, 2, 2])
    for name, scheme in SCHEMES.items():
        enough = 3.0 if name == "composition8" else math.inf  # its many kicks err more than that beyond
        assert (longest_stable_steps(scheme, saddle) * 2.0 >= enough).all(), name


def test_a_stiff_decay_beside_a_slow_growth_does():
    modes = Modes(np.array([-1000.0 + 0j]), np.array([-2000.0 + 0j]), np.array([998.0 + 0j]))
    assert modes.partners == pytest.approx([2.0])
    assert limit(SCHEMES["rk4"], modes) == pytest.approx(2.7853, rel=0.01)


K = np.array([[5.0, 2.0, 0.0], [2.0, 4.0, 0.0], [0.0, 0.0, 9.0]])
D = np.array([[0.6, 0.1, 0.0], [0.1, 0.55, 0.0], [0.0, 0.0, 2.0]])  # of the same axes as K
TURN = np.array([[0.0, 3.0, 0.0], [-3.0, 0.0, 0.0], [0.0, 0.0, 0.0]])

LINEAR = """\
duration: 1
fps: {fps}
precision: double
particles:
  basis:
    positions: [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0], [0, 0, 0], [0, 0, 0]]
    velocities: [[0, 0, 0], [0, 0, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
forces: [{{type: force_field, force: {force}}}]
integrator: {{type: {scheme}, dt: 10}}
"""


def amplification(tmp_path, scheme, by_position, by_velocity, step):
    """The matrix of one step of the scheme as the kernels take it."""
    rows = (np.hstack([by_position, by_velocity])).tolist()
    force = [" + ".join(f"({c})*{name}" for c, name in zip(row, "xyzuvw", strict=True)) for row in rows]
    path = tmp_path / "linear.yaml"
    path.write_text(LINEAR.format(fps=1 / step, force=force, scheme=scheme))
    simulation = Simulation(load_scene(path))
    simulation.system.advance(step)
    return simulation.system.get_state().reshape(6, 6)


@pytest.mark.parametrize(
    ("scheme", "by_velocity"),
    [("rk3", -D), ("symplectic_euler", -D), ("symplectic_euler", TURN), ("radau_iia", TURN - D)],
)
def test_kernels_grow_what_is_said_to_grow(tmp_path, scheme, by_velocity):
    by_position = -K if scheme != "symplectic_euler" or by_velocity is not TURN else np.diag([0.0, 0.0, -9.0])
    step = 0.8
    matrix = amplification(tmp_path, scheme, by_position, by_velocity, step)
    modes = modes_of(by_position[None], by_velocity[None]).shaped(-1)
    radius = np.abs(np.linalg.eigvals(matrix)).max()
    assert growth(SCHEMES[scheme], modes, step).max() == pytest.approx(radius, rel=1e-5)
    assert growth(SCHEMES[scheme], modes, 0.9 * step).max() != pytest.approx(radius, rel=1e-3)

"""Springs, drag along a body and pins: against NumPy, known motions, conserved quantities, hard cases."""

import math

import numpy as np
import pytest

from particlecli import simulate
from particlecli.dynamics.coupled.links import Lattice
from particlecli.scene.checks import problems
from tests.dynamics.scenes import scene, system

CLOTH = {"type": "grid", "counts": [5, 1, 7], "spacing": 0.1}
STIFFNESS, DAMPING = 40.0, 0.3
MUSCLES = "sqrt(l**2 - 0.0036)*(1 + 0.1*side*sin(2*t + 3*s))"  # real for all springs, if not for any length


@pytest.fixture(scope="module", params=[pytest.param("single", marks=pytest.mark.slow), "double"])
def cloth(request):
    """A crumpled cloth with springs and drag, and a chain beside it, at t = 0.4 s."""
    random = np.random.default_rng(2)
    found = system(
        1,
        precision=request.param,
        particles={
            "rope": {"layout": {"type": "line", "start": [5, 0, 0], "end": [6, 0, 0], "count": 3}},
            "cloth": {"layout": CLOTH, "mass": {"uniform": [0.5, 2]}},
        },
        forces=[
            {"type": "springs", "stiffness": STIFFNESS, "damping": DAMPING, "rest_length": MUSCLES},
            {"type": "body_drag", "along": 0.1, "backward": 0.5, "across": 2, "on": ["cloth"]},
        ],
    )
    state = found.get_state()
    found.set_state(state + 0.03 * random.normal(size=len(state)))
    return found


def parts(found):
    """Positions, velocities and accelerations of the cloth at 0.4 s, shape (3, n) each, and its masses."""
    state, slope = found.get_state()[18:].reshape(6, -1), found.derivative(0.4)[18:].reshape(6, -1)
    mass = 1 / found.groups["cloth"].state.read(("inverse_mass",))[0].astype(float)
    return state[:3], state[3:], slope[3:], mass


def expected(x, v, stiffness, damping):
    """Forces on the particles of the cloth, and the energy of its springs."""
    lattice = Lattice((5, 1, 7))
    i, j = lattice.pairs(("structural", "shear", "bend")).T
    s, side = (each[np.stack([i, j])].mean(axis=0) for each in lattice.places())
    places = np.stack(np.unravel_index(np.arange(35), (5, 1, 7), order="F")) * 0.1
    rest = np.sqrt(((places[:, j] - places[:, i]) ** 2).sum(axis=0) - 0.0036) * (1 + 0.1 * side * np.sin(0.8 + 3 * s))
    span, closing = x[:, j] - x[:, i], v[:, j] - v[:, i]
    length = np.linalg.norm(span, axis=0)
    pull = (stiffness * (length - rest) + damping * (closing * span).sum(axis=0) / length) * span / length
    force = np.zeros_like(x)
    np.add.at(force.T, i, pull.T)
    np.add.at(force.T, j, -pull.T)
    return force, 0.5 * stiffness * ((length - rest) ** 2).sum()


def drag(x, v, along=0.1, backward=0.5, across=2.0):
    behind, ahead = Lattice((5, 1, 7)).neighbours()
    e = x[:, ahead] - x[:, behind]
    e /= np.linalg.norm(e, axis=0)
    onward = (v * e).sum(axis=0)
    return -np.where(onward > 0, along, backward) * onward * e - across * (v - onward * e)


def test_forces_and_energy_equal_the_formulas(cloth):
    x, v, a, mass = parts(cloth)
    force, energy = expected(x, v, STIFFNESS, DAMPING)
    tolerance = 1e-12 if cloth.plan.scene.precision == "double" else 3e-5
    np.testing.assert_allclose(a * mass, force + drag(x, v), rtol=0, atol=tolerance * np.abs(force).max())
    assert cloth.coupled.potential_energies(0.4)["cloth"].sum() == pytest.approx(energy, rel=10 * tolerance)


@pytest.mark.parametrize("number", ["stiffness", "damping", "along", "backward", "across"])
@pytest.mark.parametrize("factor", [-1.0, 1.001])
def test_a_formula_with_one_number_wrong_does_not_match(cloth, number, factor):
    x, v, a, mass = parts(cloth)
    pull = {"stiffness": STIFFNESS, "damping": DAMPING}
    slowing = {"along": 0.1, "backward": 0.5, "across": 2.0}
    for numbers in (pull, slowing):
        if number in numbers:
            numbers[number] *= factor
    wrong = expected(x, v, **pull)[0] + drag(x, v, **slowing)
    assert np.abs(a * mass - wrong).max() > 1e-4 * np.abs(wrong).max() * abs(factor - 1)


def test_springs_are_the_gradient_of_their_energy_and_push_as_much_as_they_are_pushed():
    found = system(
        1,
        precision="double",
        particles={"cloth": {"layout": CLOTH, "mass": 2}},
        forces=[{"type": "springs", "stiffness": 7}],
    )
    random = np.random.default_rng(1)
    start = found.get_state() + 0.03 * random.normal(size=found.dim)
    found.set_state(start)
    x, a = start[:105].reshape(3, -1), found.derivative(0)[105:].reshape(3, -1)
    assert np.abs(a.sum(axis=1)).max() < 1e-13 * np.abs(a).sum()
    assert np.abs(np.cross(x.T, a.T).sum(axis=0)).max() < 1e-13 * np.abs(a).sum()
    nudge = np.concatenate([random.normal(size=105), np.zeros(105)])
    energies = []
    for step in (1e-6, -1e-6):
        found.set_state(start + step * nudge)
        energies.append(found.coupled.potential_energies(0)["cloth"].sum())
    assert (energies[1] - energies[0]) / 2e-6 == pytest.approx(2 * (a.ravel() @ nudge[:105]), rel=1e-6)


def swing(**more):
    force = {"type": "springs", "stiffness": 100, "rest_length": 1, "pairs": [[0, 1]], **more}
    return {"precision": "double", "forces": [force], "integrator": {"type": "dop853", "tolerance": 1e-12}}


@pytest.fixture(scope="module")
def swings():
    """Frames of a light mass on a heavy one, of a spring of no length, and of a mass below a pin that swings."""
    particles = {
        "unequal": {"positions": [[0, 0, 0], [1.1, 0, 0]], "masses": [1e6, 1]},
        "point": {"positions": [[1, 2, 3], [1, 2, 3]]},
        "hanging": {
            "positions": [[0, 1, 0], [0, 0, 0]],
            "pins": [{"where": "y > 0.5", "path": ["x", "y + 0.1*sin(3*t)", "z"]}],
        },
    }
    return list(simulate(scene(particles=particles, **swing()), threads=1))


def test_two_masses_of_ratio_a_million_swing_at_the_frequency_of_their_reduced_mass(swings):
    reduced = 1 / (1 + 1e-6)
    x = swings[-1].groups["unequal"].positions[:, 0]
    assert x[1] - x[0] == pytest.approx(1 + 0.1 * math.cos(math.sqrt(100 / reduced)), abs=1e-10)
    assert 1e6 * x[0] + x[1] == pytest.approx(1.1, abs=1e-8)


def test_a_spring_of_no_length_pulls_in_no_direction(swings):
    np.testing.assert_array_equal(swings[-1].groups["point"].positions, [[1, 2, 3], [1, 2, 3]])


def test_particles_of_a_cloth_in_one_place_have_finite_accelerations(cloth):
    start = cloth.get_state()
    crowded = start.copy()
    crowded[18:].reshape(6, -1)[:3, 1] = crowded[18:].reshape(6, -1)[:3, 0]
    cloth.set_state(crowded)
    slope = cloth.derivative(0.4)
    cloth.set_state(start)
    assert np.isfinite(slope).all()


def test_a_spring_breaks_at_its_strain_for_both_ends_and_for_good():
    pair = {"positions": [[0, 0, 0], [1, 0, 0]], "velocities": [[-3, 0, 0], [3, 0, 0]]}
    gentle = {**pair, "velocities": [[-1, 0, 0], [1, 0, 0]]}
    parts = swing(breaks_at=0.2) | {"integrator": {"type": "rk4", "dt": 1 / 1000}}
    frames = list(simulate(scene(particles={"pair": pair, "gentle": gentle}, **parts), threads=1))
    speeds = [frame.groups["pair"].velocities[:, 0] for frame in frames[1:]]
    left = math.sqrt(9 - 0.2**2 * 100 / 2)  # half the kinetic energy each, less the energy at the strain
    np.testing.assert_allclose(speeds, [[-left, left]] * len(speeds), rtol=0.01)
    assert len({tuple(pair) for pair in np.round(speeds, 12)}) == 1
    stretch = [np.diff(frame.groups["gentle"].positions[:, 0])[0] - 1 for frame in frames]
    right = [2 / math.sqrt(200) * math.sin(math.sqrt(200) * frame.time) for frame in frames]
    np.testing.assert_allclose(stretch, right, atol=1e-6)


def test_pins_stay_or_go_where_they_are_told_and_carry_what_hangs_on_them(swings):
    """x″ = −ω² (x − A sin Ωt) from rest."""
    for frame in swings:
        t, group = frame.time, frame.groups["hanging"]
        np.testing.assert_allclose(group.positions[0], [0, 1 + 0.1 * math.sin(3 * t), 0], atol=1e-13)
        np.testing.assert_allclose(group.velocities[0], [0, 0.3 * math.cos(3 * t), 0], atol=1e-13)
        right = 10 / 91 * (math.sin(3 * t) - 0.3 * math.sin(10 * t))
        assert group.positions[1, 1] == pytest.approx(right, abs=1e-9)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"positions": [[0, 0, 0], [1, 0, 0]]}, "nothing tells which particles belong together"),
        ({"layout": CLOTH, "lifetime": 1}, "can die, which springs cannot cope with"),
    ],
)
def test_groups_that_cannot_be_bodies_are_refused(parts, message):
    force = {"type": "springs", "stiffness": 1}
    found = problems(scene(particles={"a": parts}, forces=[force], integrator={"type": "rk4"}))
    assert message in dict(found)["forces", 0, "type"]


def test_pairs_must_exist_and_pins_must_have_something_to_hold():
    force = {"type": "springs", "stiffness": 1, "pairs": [[0, 0], [0, 5]], "on": ["a"]}
    pinned = {"positions": [[0, 0, 0]], "pins": [{"where": "y < 1"}]}
    groups = {"a": {"positions": [[0, 0, 0], [1, 0, 0]]}, "b": pinned}
    found = dict(problems(scene(particles=groups, forces=[force], integrator={"type": "rk4"})))
    assert "with itself" in found["forces", 0, "pairs", 0]
    assert "has 2 particles" in found["forces", 0, "pairs", 1]
    assert "motion: fixed" in found["particles", "b", "pins"]


def test_a_soft_body_keeps_its_momentum_and_angular_momentum_to_rounding():
    body = {"layout": {"type": "grid", "counts": [3, 4, 5], "spacing": 0.1}, "mass": {"uniform": [0.5, 2]}}
    spun = {**body, "velocity": [{"uniform": [-1, 1]}] * 3}
    found = system(
        1,
        precision="double",
        particles={"body": spun},
        forces=[{"type": "springs", "stiffness": 500, "breaks_at": 0.5}],
        integrator={"type": "velocity_verlet", "dt": 1 / 500},
    )

    def momenta():
        state = found.groups["body"].state
        mass = 1 / state.read(("inverse_mass",))[0]
        x, v = state.read(("x", "y", "z")), state.read(("u", "v", "w"))
        return np.concatenate([(mass * v).sum(axis=1), np.cross(x.T, (mass * v).T).sum(axis=0)])

    found.advance(0.0)
    before = momenta()
    found.advance(1.0)
    np.testing.assert_allclose(momenta(), before, rtol=0, atol=1e-12)


@pytest.mark.slow
def test_a_chain_of_a_thousand_stiff_links_holds_a_heavy_end():
    """It stretches as one spring of a thousandth of the stiffness, by the end's weight and half its own."""
    links, stiffness, mass, end = 1000, 1e6, 1e-3, 10.0
    places = [[0, -0.001 * i, 0] for i in range(links + 1)]
    chain = {
        "positions": places,
        "masses": [mass] * links + [end],
        "pins": [{"where": "y > -0.0005"}],
    }
    pairs = [[i, i + 1] for i in range(links)]
    parts = {
        "particles": {"chain": chain},
        "forces": [{"type": "gravity"}, {"type": "springs", "stiffness": stiffness, "pairs": pairs}],
        "integrator": {"type": "implicit_euler", "dt": 0.1},
        "precision": "double",
    }
    *_, frame = simulate(scene(**parts), threads=2)
    stretch = -1.0 - frame.groups["chain"].positions[-1, 1]
    assert stretch == pytest.approx(links / stiffness * 9.80665 * (end + mass * links / 2), rel=0.3)

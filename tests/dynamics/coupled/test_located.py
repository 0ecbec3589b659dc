"""Impacts of a few coupled particles at their instants: order, energy, rest, release, hard cases, against SciPy."""

import numpy as np
import pytest

from particlecli import simulate
from particlecli.dynamics.plan import make_plan
from tests.dynamics.scenes import scene, system

G = 9.80665
STIFFNESS = 60.0
RESTITUTION = 0.8
SPRING = {"type": "springs", "pairs": [[0, 1]], "stiffness": STIFFNESS, "rest_length": 1.0}
PAIR = {
    "duration": 100,
    "particles": {"a": {"positions": [[0, 0.5, 0], [0.4, 1.5, 0.2]], "masses": [1.0, 2.0]}},
    "forces": [{"type": "gravity"}, SPRING],
    "planes": [{"restitution": RESTITUTION}],
}
THROWN = np.array([0, 0.4, 0.5, 1.5, 0, 0.2, 0.3, 0, 0, 0.5, 0, -0.2])
"""x, y, z, u, v, w of both, one row after the other."""


def made(scheme="rk4", **parts):
    integrator = parts.pop("integrator", {"type": scheme, "dt": 0.01})
    return system(1, **{"precision": "double", **PAIR, "integrator": integrator, **parts})


@pytest.fixture(scope="module")
def pairs():
    """Two masses on a spring above a plane, by scheme."""
    return {scheme: made(scheme) for scheme in ("rk4", "velocity_verlet")}


def gone(pair, state, until, steps):
    """Where a pair goes from a state in equal steps."""
    pair.set_state(np.asarray(state, float))
    pair.coupled.advance(0.0, until, steps)
    return pair.get_state()


def right(state, until, stiffness=STIFFNESS, restitution=RESTITUTION):
    """Where the pair goes, with the instants of impacts and releases as SciPy finds them; and how many there were."""
    from scipy.integrate import solve_ivp

    masses, resting = np.array([1.0, 2.0]), [False, False]
    state, time, events = np.array(state, float), 0.0, 0

    def accelerations(y):
        x = y[:6].reshape(3, 2)
        d = x[:, 1] - x[:, 0]
        size = np.sqrt(d @ d)
        pull = stiffness * (size - 1.0) * d / size
        a = np.stack([pull, -pull], axis=1) / masses
        a[1] -= G
        return a

    def slope(_, y):
        a = accelerations(y)
        a[1][resting] = 0.0
        return np.concatenate([y[6:], a.ravel()])

    def event(particle):
        def changes(_, y):
            return -accelerations(y)[1][particle] if resting[particle] else y[2 + particle]

        changes.terminal, changes.direction = True, -1
        return changes

    for particle in range(2):
        resting[particle] = bool(state[2 + particle] == state[8 + particle] == 0.0)
    while time < until:
        found = solve_ivp(
            slope, (time, until), state, method="DOP853", rtol=1e-13, atol=1e-13, events=[event(0), event(1)]
        )
        time, state = found.t[-1], found.y[:, -1].copy()
        for particle in range(2):
            if len(found.t_events[particle]):
                events += 1
                resting[particle], state[2 + particle] = False, 0.0
                state[8 + particle] *= -restitution
    return state, events


def order(pair, state, until, counts):
    exact, events = right(state, until)
    errors = [np.abs(gone(pair, state, until, count) - exact).max() for count in counts]
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0], events


@pytest.mark.parametrize(("scheme", "declared", "counts"), [
    ("velocity_verlet", 2, (400, 800, 1600)),
    ("rk4", 4, (100, 200, 400, 800)),
])  # fmt: skip
def test_order_is_kept_through_bounces(pairs, scheme, declared, counts):
    found, events = order(pairs[scheme], THROWN, 1.5, counts)
    assert events == 8
    assert found == pytest.approx(declared, abs=0.2)


PRESSED = np.array([0, 0, 0, 0.05, 0, 0, 0, 0, 0, 0, 0, 0])
"""The spring throws the upper one up until it takes the lower one along, which rested and is back before 0.9 s."""


@pytest.mark.parametrize(("scheme", "declared", "counts"), [
    ("velocity_verlet", 2, (100, 200, 400, 800)),
    ("rk4", 4, (50, 100, 200, 400)),
])  # fmt: skip
def test_order_is_kept_where_a_resting_particle_is_drawn_off(pairs, scheme, declared, counts):
    found, events = order(pairs[scheme], PRESSED, 0.9, counts)
    assert events == 2
    assert found == pytest.approx(declared, abs=0.2)


def test_nothing_goes_through_at_a_thousand_metres_a_second(pairs):
    thrown = np.array([0, 0.5, 30, 31, 0, 0, 0, 0, -1000, -900, 0, 0])
    end = gone(pairs["rk4"], thrown, 0.1, 1)
    exact, events = right(thrown, 0.1)
    assert events == 2
    np.testing.assert_allclose(end, exact, rtol=0.02, atol=0.3)
    pair = pairs["rk4"]
    for _ in range(200):
        pair.coupled.advance(0.0, 0.1, 1)
        assert pair.get_state()[2:4].min() >= 0.0


def test_a_pair_at_rest_neither_sinks_nor_creeps(pairs):
    stands = np.array([0, 0, 0, 1.0 - 2.0 * G / STIFFNESS, 0, 0, 0, 0, 0, 0, 0, 0])
    end = gone(pairs["rk4"], stands, 100.0, 10_000)
    np.testing.assert_array_equal(end[[0, 2, 4, 6, 8, 10]], 0.0)
    np.testing.assert_allclose(end, stands, rtol=0, atol=1e-12)


def test_many_bounces_of_a_particle_end_in_rest(pairs):
    """The lower one is dropped from a hair's breadth below the other: its bouncing ends long before it is drawn off."""
    loose = np.array([0, 0, 1e-5, 1.0 - 2.0 * G / STIFFNESS + 1e-5, 0, 0, 0, 0, 0, 0, 0, 0])
    end = gone(pairs["rk4"], loose, 0.2, 20)
    assert end[2] == end[8] == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("scheme", ["symplectic_euler", "rk4", "yoshida4", "dormand_prince"])
def test_what_falls_with_damping_and_friction_lies_still_in_the_end(scheme, precision):
    adapts = scheme == "dormand_prince"
    pair = made(
        integrator={"type": scheme, **({"tolerance": 1e-6} if adapts else {"dt": 0.01})},
        precision=precision,
        forces=[{"type": "gravity"}, {**SPRING, "damping": 1.0}],
        planes=[{"restitution": 0.5, "friction": 0.3}],
    )
    for frame in range(1, 201):
        pair.advance(0.1 * frame)
        assert pair.get_state()[2:4].min() >= 0.0
    lies = pair.get_state()
    np.testing.assert_array_equal(lies[2:4], 0.0)
    np.testing.assert_array_equal(lies[6:], 0.0)
    pair.advance(30.0)
    np.testing.assert_array_equal(pair.get_state(), lies)


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "ratio"), [("velocity_verlet", 4), ("rk4", 16)])
def test_elastic_bounces_keep_the_energy_to_the_order_of_the_scheme(scheme, ratio):
    pair = made(scheme, planes=[{"restitution": 1}])

    def energy(state):
        x, v = state[:6].reshape(3, 2), state[6:].reshape(3, 2)
        moving = 0.5 * (v**2).sum(axis=0) @ [1.0, 2.0]
        return moving + G * x[1] @ [1.0, 2.0] + STIFFNESS / 2 * (np.linalg.norm(x[:, 0] - x[:, 1]) - 1) ** 2

    def drift(steps):
        pair.set_state(THROWN)
        drifts = []
        for part in range(100):
            pair.coupled.advance(0.05 * part, 0.05, steps)
            drifts.append(abs(energy(pair.get_state()) / energy(THROWN) - 1.0))
        return max(drifts)

    coarse, fine = drift(5), drift(10)
    assert fine < 1e-3
    assert coarse > 0.6 * ratio * fine


@pytest.mark.slow
def test_corners_and_wedges_hold():
    normals = np.array([[0, 1, 0], [1, 0.3, 0], [-0.2, 0.5, 1], [-1, 0.1, 0]])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    pair = made(planes=[{"normal": [*normal], "point": [0, 0, 0], "restitution": 0.7} for normal in normals[:3]]
                + [{"normal": [*normals[3]], "point": [2, 0, 0], "restitution": 0.7, "friction": 0.2}])  # fmt: skip
    pair.set_state(np.array([0.5, 1, 0.6, 1.2, 0.7, 1, -100, -50, -130, -100, -80, -90.0]))
    offsets = np.array([0, 0, 0, normals[3] @ [2, 0, 0]])
    for frame in range(1, 301):
        pair.advance(0.1 * frame)
        heights = normals @ pair.get_state()[:6].reshape(3, 2) - offsets[:, None]
        assert heights.min() > -1e-12


@pytest.mark.slow
@pytest.mark.parametrize("restitution", [0.9, 1.0])
def test_a_slit_of_a_millimetre_is_not_left_and_ends(restitution):
    """Where impacts are too many to follow, particles come to rest within."""
    pair = made(
        planes=[
            {"restitution": restitution},
            {"point": [0, 0.001, 0], "normal": [0, -1, 0], "restitution": restitution},
        ]
    )
    pair.set_state(np.array([0, 0.5, 4e-4, 6e-4, 0, 0, 0, 3, -1000, 900, 0, 0]))
    for frame in range(1, 4):
        pair.coupled.advance(0.1 * frame, 0.1, 1)
        heights = pair.get_state()[2:4]
        assert heights.min() >= 0.0
        assert heights.max() <= 0.001


@pytest.mark.slow
@pytest.mark.parametrize("hit", ["stick", "die"])
def test_a_particle_that_sticks_or_dies_does_so_at_its_instant(hit):
    """Without gravity and force they come down with 1 and 0.5 m/s."""
    pair = made(
        planes=[{"on_hit": hit}],
        forces=[{"type": "attraction", "strength": 1e-30, "softening": 1}],
        integrator={"type": "rk4", "dt": 0.07},
    )
    pair.set_state(np.array([0, 5, 0.55, 1.1, 0, 0, 1, 1, -1, -0.5, 0, 0]))
    pair.advance(0.7)
    state = pair.get_state()
    if hit == "die":
        assert pair.deaths == {"a": {"plane": 1}}
        np.testing.assert_allclose(state, [5.7, 0.75, 0, 1, -0.5, 0], atol=1e-12)
    else:
        np.testing.assert_allclose(state, [0.55, 5.7, 0, 0.75, 0, 0, 0, 1, 0, -0.5, 0, 0], atol=1e-12)


@pytest.mark.slow
def test_births_deaths_friction_and_cooling_go_as_in_groups_of_single_particles():
    """RK4 is exact under gravity, so that cutting the step of all changes nothing where none feels another."""
    sparks = {
        "rate": 100,
        "shape": {"type": "ball", "center": [0, 0.2, 0], "radius": 0.1},
        "direction": {"axis": [0, 1, 0], "spread": 90},
        "speed": {"uniform": [0, 2]},
        "lifetime": {"uniform": [0.4, 0.9]},
        "temperature": 1000,
        "cooling": {"rate": 1},
    }
    parts = {
        "duration": 1.5,
        "precision": "double",
        "emitters": {"sparks": sparks},
        "planes": [
            {"restitution": 0.5, "friction": 0.2},
            {"point": [1, 0, 0], "normal": [-1, 0, 0], "on_hit": "stick"},
        ],
        "integrator": {"type": "rk4", "dt": 0.02},
    }
    weak = {"type": "attraction", "strength": 1e-30, "softening": 1}
    *_, together = simulate(scene(**parts, forces=[{"type": "gravity"}, weak]), threads=1)
    *_, single = simulate(scene(**parts, forces=[{"type": "gravity"}]), threads=1)
    mine, theirs = together.groups["sparks"], single.groups["sparks"]
    np.testing.assert_array_equal(mine.ids, theirs.ids)
    np.testing.assert_allclose(mine.positions, theirs.positions, rtol=0, atol=1e-9)
    np.testing.assert_allclose(mine.velocities, theirs.velocities, rtol=0, atol=1e-8)
    np.testing.assert_allclose(mine.temperatures, theirs.temperatures, rtol=1e-12)


def planned(**parts):
    (group,) = make_plan(scene(**{**PAIR, **parts})).groups
    return group.impacts


def test_plans_tell_when_impacts_happen():
    many = {"a": {"layout": {"type": "box", "size": [1, 1, 1], "count": 600}}}
    attraction = [{"type": "attraction", "strength": 1}]
    assert planned() == "located"
    assert planned(planes=[]) is None
    assert planned(integrator={"type": "implicit_euler"}) == "end_of_step"
    assert planned(integrator={"type": "rk4", "contact": "end_of_step"}) == "end_of_step"
    assert planned(forces=[{"type": "soft_sphere", "diameter": 0.1, "stiffness": 1}]) == "end_of_step"
    assert planned(forces=attraction) == "located"
    assert planned(forces=[{**attraction[0], "method": "tree"}]) == "end_of_step"
    assert planned(forces=attraction, particles=many) == "end_of_step"
    assert planned(forces=[{"type": "gravity"}], particles=many) == "located"

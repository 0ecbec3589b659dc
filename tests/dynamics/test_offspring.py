"""Children are born where and when their parents are, whatever the step, the frame rate and the threads."""

import numpy as np
import pytest

from particlecli.dynamics.kinship import Kinship, by_generation
from particlecli.dynamics.plan import make_plan
from particlecli.errors import SceneError
from particlecli.simulate import Simulation
from tests.cases import later
from tests.dynamics.scenes import scene

G = np.array([0.0, -9.0, 0.0])
GRAVITY = {"type": "gravity", "acceleration": G.tolist()}
SHELLS = {
    "rate": 3,
    "direction": {"axis": [0, 1, 0], "spread": 30},
    "speed": {"uniform": [5, 9]},
    "lifetime": {"uniform": [0.4, 0.9]},
    "children": [
        {"on": "death", "emitter": "stars", "count": 4, "inherit_velocity": 0.5},
        {"on": "way", "emitter": "trail", "rate": 13},
    ],
}
EMITTERS = {"trail": {"speed": 0}, "stars": {"direction": {"spread": 180}, "speed": 2, "children": {
    "on": "way", "emitter": "dust", "rate": 7}}, "shells": SHELLS, "dust": {"speed": 0, "lifetime": 0.3}}  # fmt: skip


def made(threads=2, fps=10, dt=0.01, kind="rk4", **parts):
    described = scene(
        duration=2,
        fps=fps,
        precision="double",
        emitters=EMITTERS,
        forces=[GRAVITY],
        integrator={"type": kind} | ({"dt": dt} if kind == "rk4" else {"tolerance": 1e-9}),
        **parts,
    )
    return Simulation(described, threads=threads)


def last_of(simulation):
    return list(simulation)[-1]


@pytest.fixture(scope="module")
def end():
    """The plan of the scene, its births by group, and its last frame."""
    simulation = made()
    frame = last_of(simulation)
    return simulation.plan, simulation.births, frame


def flown(table, elapsed):
    return table.positions + table.velocities * elapsed + 0.5 * G[:, None] * elapsed**2


def shells(plan):
    """What the shells are born with, and when their lifetimes end."""
    births = next(group.births for group in plan.groups if group.name == "shells")
    table = births.table(0, births.total)
    return table, table.times + table.lifetimes


def test_stars_come_out_of_shells_where_and_when_these_die(end):
    plan, _, frame = end
    table, ends = shells(plan)
    dead = ends <= frame.time
    stars = frame.groups["stars"]
    assert len(stars) == 4 * np.count_nonzero(dead)
    parents = stars.ids // 4
    assert sorted(set(parents)) == sorted(table.ids[dead])
    life = table.lifetimes[parents]
    born = flown(table, table.lifetimes)[:, parents]
    elapsed = frame.time - ends[parents]
    own = stars.velocities.T - G[:, None] * elapsed - 0.5 * (table.velocities[:, parents] + G[:, None] * life)
    np.testing.assert_allclose(np.linalg.norm(own, axis=0), 2.0, rtol=0, atol=1e-10)
    way = (stars.velocities.T - 0.5 * G[:, None] * elapsed) * elapsed
    np.testing.assert_allclose(stars.positions.T, born + way, rtol=0, atol=1e-10)
    np.testing.assert_allclose(stars.ages, elapsed, rtol=0, atol=1e-12)


def test_trails_are_laid_evenly_in_time_along_the_way(end):
    plan, _, frame = end
    table, ends = shells(plan)
    trail = frame.groups["trail"]
    births = table.times[:, None] + (np.arange(20) + 0.5)[None] / 13
    laid = births <= np.minimum(ends, frame.time)[:, None]
    assert len(trail) == np.count_nonzero(laid)
    per_parent = next(brood for brood in plan.broods if brood.child == "trail").each
    parents, places = np.divmod(trail.ids, per_parent)
    age = (places + 0.5) / 13
    elapsed = frame.time - (table.times[parents] + age)
    start = table.positions[:, parents] + table.velocities[:, parents] * age + 0.5 * G[:, None] * age**2
    speed = table.velocities[:, parents] + G[:, None] * age
    np.testing.assert_allclose(
        trail.positions.T, start + speed * elapsed + 0.5 * G[:, None] * elapsed**2, rtol=0, atol=1e-10
    )


@pytest.mark.parametrize("change", [{"fps": 7, "dt": 0.037}, *later({"kind": "dop853"})])
def test_neither_step_nor_frame_rate_nor_scheme_matters(end, change):
    other = last_of(made(**change))
    for name, group in end[-1].groups.items():
        again = other.groups[name]
        order, there = np.argsort(group.ids), np.argsort(again.ids)
        assert group.ids[order].tolist() == again.ids[there].tolist()
        np.testing.assert_allclose(again.positions[there], group.positions[order], rtol=0, atol=1e-8)


def test_the_number_of_threads_changes_no_bit(end):
    other = last_of(made(threads=1))
    for name, group in end[-1].groups.items():
        assert np.array_equal(group.ids, other.groups[name].ids)
        assert np.array_equal(group.positions, other.groups[name].positions)


def test_grandchildren_of_the_same_frame_are_born_too(end):
    _, births, frame = end
    assert births["dust"] > 0
    assert len(set(frame.groups["dust"].ids)) == len(frame.groups["dust"])


def test_whoever_dies_of_a_plane_bears_there():
    described = scene(
        duration=1,
        fps=10,
        precision="double",
        particles={
            "drops": {
                "positions": [[0, 1, 0]],
                "velocities": [[2, 0, 0]],
                "children": {"on": "death", "emitter": "splash", "count": 5},
            }
        },
        emitters={"splash": {"direction": {"spread": 60}, "speed": 1}},
        forces=[GRAVITY],
        planes=[{"normal": [0, 1, 0], "on_hit": "die", "on": ["drops"]}],
        integrator={"type": "rk4", "dt": 0.001},
    )
    simulation = Simulation(described)
    frames = list(simulation)
    assert simulation.deaths["drops"] == {"plane": 1}
    first = next(frame.groups["splash"] for frame in frames if len(frame.groups["splash"]))
    fall = np.sqrt(2 / 9)
    time = next(frame.time for frame in frames if len(frame.groups["splash"]))
    assert first.ages == pytest.approx(time - fall, abs=1.1e-3)
    born = first.positions.T - (first.velocities.T - 0.5 * G[:, None] * first.ages) * first.ages
    np.testing.assert_allclose(born, np.tile([[2 * fall], [0], [0]], 5), rtol=0, atol=3e-3)


@pytest.mark.parametrize("kind", ["rk4", *later("dormand_prince")])
def test_impacts_bear_where_and_when_they_are(kind):
    """A ball dropped from 1 m with restitution ½ strikes at √(2/9) s and, after 2 · ½ of that, again."""
    described = scene(
        duration=2,
        fps=10,
        precision="double",
        particles={
            "balls": {
                "positions": [[0, 1, 0], [5, 4, 0]],
                "velocities": [[3, 0, 0], [0, 0, 0]],
                "children": {"on": "impact", "emitter": "dust", "count": 3, "impacts": 2, "inherit_velocity": 0},
            }
        },
        emitters={"dust": {"speed": 0}},
        forces=[{**GRAVITY, "on": ["balls"]}],
        planes=[{"normal": [0, 1, 0], "restitution": 0.5, "on": ["balls"]}],
        integrator={"type": kind} | ({"dt": 0.05} if kind == "rk4" else {"tolerance": 1e-10}),
    )
    simulation = Simulation(described)
    dust = list(simulation)[-1].groups["dust"]
    fall = np.sqrt(2 / 9)
    right = {0: (fall, 3 * fall), 1: (2 * fall, 3 * 2 * fall), 2: (2 * fall, 5.0), 3: (4 * fall, 5.0)}
    assert sorted(dust.ids) == list(range(12))
    for number, age, position in zip(dust.ids, dust.ages, dust.positions, strict=True):
        time, place = right[number // 3]
        assert age == pytest.approx(2 - time, abs=1e-8)
        np.testing.assert_allclose(position, [place, 0, 0], rtol=0, atol=1e-7)


def test_there_is_always_room():
    simulation = made()
    most = dict.fromkeys(simulation.scene.groups, 0)
    for frame in simulation:
        for name, group in frame.groups.items():
            most[name] = max(most[name], len(group))
    for group in simulation.plan.groups:
        assert most[group.name] <= group.capacity


def test_parents_come_before_their_children():
    assert by_generation(scene(emitters=EMITTERS)) == ["shells", "trail", "stars", "dust"]


def test_children_that_cannot_be_numbered_are_refused_with_the_number():
    emitters = {
        "a": {"rate": 1e4, "lifetime": 1, "children": {"on": "death", "emitter": "b", "count": 1000}},
        "b": {"lifetime": 1, "children": {"on": "death", "emitter": "c", "count": 1000}},
        "c": {"lifetime": 1},
    }
    with pytest.raises(SceneError, match=r"up to 10,000,000,000 particles"):
        make_plan(scene(emitters=emitters, duration=1))


def test_nobody_but_children_takes_their_numbers():
    described = scene(emitters=EMITTERS | {"stars": {**EMITTERS["stars"], "rate": 10}})
    births = {group.name: group.births for group in make_plan(described).groups}
    kinship = Kinship(described, births)
    brood = next(each for each in kinship.broods if each.child == "stars")
    assert brood.first == births["stars"].total == 10
    numbers = brood.numbers(np.repeat(np.arange(3), 4), np.tile(np.arange(4), 3))
    assert numbers.tolist() == list(range(10, 22))

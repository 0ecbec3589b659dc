"""Birth tables: the same particles however they are asked for, at the right instants, in the right order."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from itertools import pairwise
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import spearmanr

from particlecli.dynamics.birth_table import BirthTable
from particlecli.dynamics.births import EmitterBirths, ParticleBirths
from particlecli.errors import SceneError
from particlecli.scene.distributions import Normal, Uniform
from particlecli.scene.groups import Emitter
from particlecli.scene.model import Scene

EVERYTHING: dict[str, Any] = {
    "shape": {"type": "ball", "radius": 0.5},
    "rate": "40*(1 + sin(3*t))",
    "bursts": [{"time": 1.5, "count": 30}, {"time": 0.25, "count": 7}],
    "start": 0.5,
    "stop": 3.5,
    "direction": {"axis": [0, 1, 1], "spread": 25},
    "speed": {"uniform": [0.5, 2.5]},
    "mass": {"log_normal": [1e-6, 0.3]},
    "lifetime": {"uniform": [0.5, 1.0]},
    "temperature": {"normal": [1500, 120]},
    "cooling": {"rate": {"uniform": [0.4, 0.6]}},
}


def births(duration: float = 4.0, seed: int = 7, name: str = "sparks", **emitter: Any) -> EmitterBirths:
    return EmitterBirths(seed, name, Emitter.model_validate(emitter or EVERYTHING), duration)


def whole(source: EmitterBirths | ParticleBirths) -> BirthTable:
    return source.table(0, source.total)


def joined(tables: list[BirthTable]) -> BirthTable:
    columns = {field.name: [getattr(table, field.name) for table in tables] for field in fields(BirthTable)}
    return BirthTable(**{n: None if c[0] is None else np.concatenate(c, axis=-1) for n, c in columns.items()})


def assert_same(one: BirthTable, other: BirthTable) -> None:
    for field in fields(BirthTable):
        first, second = getattr(one, field.name), getattr(other, field.name)
        assert (first is None) == (second is None), field.name
        assert first is None or np.array_equal(first, second), field.name


@settings(deadline=None, max_examples=40)
@given(st.lists(st.floats(0, 4), max_size=12), st.sampled_from([1, 7, 50, 4096]))
def test_births_asked_for_in_pieces_are_those_asked_for_at_once(cuts: list[float], ahead: int) -> None:
    source = births()
    ends = [-np.inf, *sorted(cuts), 4.0]
    with patch("particlecli.dynamics.births.AHEAD", ahead):
        pieces = [source.between(after, until) for after, until in pairwise(ends)]
    assert_same(joined(pieces), whole(births()))
    for piece, (after, until) in zip(pieces, pairwise(ends), strict=True):
        assert ((piece.times > after) & (piece.times <= until)).all()


def test_order_of_asking_does_not_matter() -> None:
    source = births()
    late, early = source.between(2.0, 4.0), source.between(-np.inf, 2.0)
    assert_same(joined([early, late]), whole(births()))


def test_ids_count_births_in_order_of_time() -> None:
    table = whole(births())
    assert table.ids.tolist() == list(range(births().total))
    assert (np.diff(table.times) >= 0).all()


def test_a_longer_scene_starts_with_the_same_births() -> None:
    short, long = births(duration=2.0).between(-np.inf, 1.9), births(duration=2.5).between(-np.inf, 1.9)
    assert np.abs(short.times - long.times).max() < 1e-12
    assert_same(replace(short, times=long.times), long)


def test_seed_and_name_and_nothing_else_choose_the_particles() -> None:
    reference = whole(births())
    for other in (births(seed=8), births(name="embers")):
        assert (whole(other).times == reference.times).all()
        assert not (whole(other).positions == reference.positions).any()


def test_a_further_quantity_leaves_the_others_alone() -> None:
    plain = whole(births(rate=20, lifetime={"uniform": [1, 2]}))
    changed = {"rate": 20, "bursts": [], "start": 0, "stop": None, "lifetime": {"uniform": [1, 2]}}
    richer = whole(births(**EVERYTHING | changed))
    assert (plain.lifetimes == richer.lifetimes).all()


def test_quantities_do_not_depend_on_each_other() -> None:
    table = whole(births(**EVERYTHING | {"rate": 3000}))
    velocities = table.velocities - np.outer([0, 1, 1], [1, 1] @ table.velocities[1:] / 2)
    columns = [*table.positions, np.linalg.norm(table.velocities, axis=0), velocities[0]]
    columns += [table.masses, table.lifetimes, table.temperatures, table.cooling_rates]
    correlations = spearmanr(np.array(columns), axis=1).statistic - np.eye(len(columns))
    assert np.abs(correlations).max() < 5 / np.sqrt(len(table))


def test_only_what_differs_between_particles_is_an_array() -> None:
    table = whole(births(rate=20, lifetime=2, temperature=900, cooling={"rate": 0.5}))
    assert table.masses is None
    assert table.cooling_rates is None
    assert table.lifetimes.tolist() == [2.0] * 80
    assert table.temperatures.tolist() == [900.0] * 80
    bare = whole(births(rate=20))
    assert bare.lifetimes is bare.temperatures is bare.masses is bare.cooling_rates is None
    assert (bare.velocities == 0).all()


def test_a_first_order_group_has_no_velocities() -> None:
    assert whole(births(rate=20, motion="first_order", flow="wind")).velocities is None


def test_speeds_and_directions() -> None:
    velocities = whole(births()).velocities
    speeds = np.linalg.norm(velocities, axis=0)
    cosines = np.array([0, 1, 1]) / np.sqrt(2) @ (velocities / speeds)
    assert 0.5 <= speeds.min() < speeds.max() <= 2.5
    assert cosines.min() >= np.cos(np.radians(25)) - 1e-12


def test_what_a_plan_wants_to_know() -> None:
    assert births().has_masses
    assert births().has_temperature
    assert births().hottest == Normal(normal=(1500, 120)).support[1]
    plain = births(rate=1)
    assert not plain.has_masses
    assert not plain.has_temperature
    assert plain.hottest is None


def scene(**group: Any) -> Scene:
    return Scene.model_validate({"duration": 1, "particles": {"bodies": group}})


def test_listed_particles_are_as_listed() -> None:
    source = ParticleBirths(
        scene(
            positions=[[0, 1, 2], [3, 4, 5]],
            velocities=[[1, 0, 0], [0, 0, 2]],
            masses=[1, 1e-3],
            temperatures=[300, 900],
        ),
        "bodies",
    )
    table = whole(source)
    assert (source.total, source.has_masses, source.has_temperature, source.hottest) == (2, True, True, 900)
    assert table.ids.tolist() == [0, 1]
    assert table.times.tolist() == [0, 0]
    assert table.positions.T.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert table.velocities.T.tolist() == [[1, 0, 0], [0, 0, 2]]
    assert table.masses.tolist() == [1, 1e-3]
    assert table.temperatures.tolist() == [300, 900]
    assert table.lifetimes is None
    assert_same(joined([source.table(0, 1), source.table(1, 2)]), table)


def test_laid_out_particles_draw_what_they_are_born_with() -> None:
    group = {
        "layout": {"type": "ball", "radius": 2, "count": 500},
        "velocity": [1, {"uniform": [2, 3]}, {"normal": [0, 1]}],
        "mass": {"choice": [1, 2]},
        "lifetime": {"uniform": [1, 2]},
        "temperature": 400,
        "cooling": {"rate": {"uniform": [1, 2]}},
    }
    source = ParticleBirths(scene(**group), "bodies")
    table = whole(source)
    assert (source.total, source.has_masses, source.has_temperature, source.hottest) == (500, True, True, 400)
    assert (table.velocities[0] == 1).all()
    assert Uniform(uniform=(2, 3)).uniform[0] <= table.velocities[1].min() < table.velocities[1].max() <= 3
    assert abs(np.corrcoef(table.velocities[1:])[0, 1]) < 0.2
    assert set(table.masses.tolist()) == {1, 2}
    assert (table.temperatures == 400).all()
    assert_same(joined([source.table(0, 1), source.table(1, 123), source.table(123, 500)]), table)


def test_velocities_by_expressions_are_of_places_in_the_frame() -> None:
    disc = {"type": "lattice", "size": [2, 2, 0], "spacing": 0.1, "where": "x**2 + y**2 < 1"}
    turned = {"frames": {"table": {"translate": [5, 0, 0], "rotate": {"axis": [0, 0, 1], "angle": math.pi / 2}}}}
    group = {"layout": disc, "velocity": ["-100*x", "100*y", 7]}
    plain = whole(ParticleBirths(scene(**group), "bodies"))
    assert plain.velocities == pytest.approx(plain.positions * [[-100], [100], [0]] + [[0], [0], [7]])
    data = {"duration": 1, "particles": {"bodies": {**group, "frame": "table"}}, **turned}
    moved = whole(ParticleBirths(Scene.model_validate(data), "bodies"))
    assert moved.velocities == pytest.approx(
        (moved.positions - [[5], [0], [0]]) * [[100], [-100], [0]] + [[0], [0], [7]]
    )
    with pytest.raises(SceneError, match="not finite where particle 1"):
        whole(ParticleBirths(scene(positions=[[1, 0, 0], [-1, 0, 0]], velocity=["log(x)", 0, 0]), "bodies"))


def test_particles_at_rest_and_first_order_particles() -> None:
    assert (whole(ParticleBirths(scene(positions=[[0, 0, 0]]), "bodies")).velocities == 0).all()
    drifting = scene(positions=[[0, 0, 0]], motion="first_order", flow="wind")
    assert whole(ParticleBirths(drifting, "bodies")).velocities is None


def test_other_groups_and_frame_rates_change_nothing() -> None:
    box = {"layout": {"type": "box", "size": [1, 1, 1], "count": 50}}
    plain = Scene.model_validate({"duration": 1, "particles": {"bodies": box}})
    crowded = Scene.model_validate(
        {
            "duration": 1,
            "fps": 60,
            "integrator": {"dt": 0.0025},
            "particles": {"another": box, "bodies": box},
            "emitters": {"sparks": {"rate": 5}},
        }
    )
    assert_same(whole(ParticleBirths(plain, "bodies")), whole(ParticleBirths(crowded, "bodies")))
    another = whole(ParticleBirths(crowded, "another"))
    assert not (another.positions == whole(ParticleBirths(plain, "bodies")).positions).any()

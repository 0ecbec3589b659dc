from __future__ import annotations

import numpy as np
import pytest
from pydantic import TypeAdapter

from particlecli.render.blackbody import glow
from particlecli.render.colour import LUMINANCE, from_hex
from particlecli.render.palettes import GROUP_COLORS
from particlecli.render.tint import Tint, tint_of
from particlecli.scene.look import Color


def tint(color: object, place: int = 0) -> Tint:
    return tint_of(TypeAdapter(Color).validate_python(color), place)


def test_a_constant_has_one_place() -> None:
    one = tint("#ff8000")
    assert one.last == 0
    assert one.table[0, :3] == pytest.approx(from_hex("#ff8000"))
    assert one.needs == frozenset()


def test_groups_take_turns() -> None:
    assert tint("group", 1).table[0, :3] == pytest.approx(from_hex(GROUP_COLORS[1]))
    assert np.array_equal(tint("group", 0).table, tint("group", len(GROUP_COLORS)).table)


def test_black_bodies_look_up_their_temperature() -> None:
    body = tint({"blackbody": 1500})
    assert body.quantity == "temperature"
    place = round((1200 - body.low) / (body.high - body.low) * body.last)
    assert body.table[place, :3] == pytest.approx(glow(1200.0, 1500.0), rel=0.02)


@pytest.mark.parametrize(
    ("by", "fields"),
    [
        ("age", {"ages", "lifetimes"}),
        ("speed", {"velocities"}),
        ("temperature", {"temperatures"}),
        ("id", set()),
    ],
)
def test_a_map_needs_what_it_looks_up(by: str, fields: set[str]) -> None:
    assert tint({"by": by, "map": "ice", "range": [0, 2]}).needs == fields


def test_the_fourth_column_is_luminance() -> None:
    table = tint({"by": "age", "map": ["#102030", "#ffee00"]}).table
    assert table[:, 3] == pytest.approx(table[:, :3] @ LUMINANCE, rel=1e-5)

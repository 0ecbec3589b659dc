from __future__ import annotations

import numpy as np
import pytest

from particlecli.frame import GroupFrame
from particlecli.render.points import PointLook
from particlecli.scene.look import PLAIN_PIXELS, GroupLook

RAMP = {"map": ["#000000", "#ffffff"], "range": [0, 10]}


def look(**style: object) -> PointLook:
    return PointLook(GroupLook.model_validate(style), 0)


def group(**fields: np.ndarray) -> GroupFrame:
    return GroupFrame(np.arange(3), np.zeros((3, 3)), **fields)


def colors(look: PointLook, group: GroupFrame) -> list[int]:
    shades = look.shades(group)
    assert shades is not None
    return [int(color) for color in look.palette[shades]]


def test_sizes_are_metres_or_negative_pixels() -> None:
    assert look(radius=0.1).radius == 0.1
    assert look(pixels=3).radius == -3
    assert look().radius == -PLAIN_PIXELS


def test_one_colour_for_all_is_one_number() -> None:
    assert look(color="#4080c0").palette.tolist() == [0x4080C0FF]
    assert look(color="#4080c0").shades(group()) is None


def test_light_brighter_than_white_keeps_its_hue() -> None:
    assert look(color="#800000", brightness=100.0).palette.tolist() == [0xFF0000FF]


@pytest.mark.parametrize(
    ("by", "fields"),
    [
        ("speed", {"velocities": np.array([[0, 0, 0], [3, 4, 0], [0, 0, 99]])}),
        ("temperature", {"temperatures": np.array([-5, 5, 10])}),
        ("age", {"ages": np.array([0, 5, 11])}),
    ],
)
def test_colours_follow_the_quantity(by: str, fields: dict[str, np.ndarray]) -> None:
    mapped = look(color={"by": by, **RAMP})
    assert mapped.needs >= fields.keys()
    low, middle, high = colors(mapped, group(**fields))
    assert (low, high) == (0x000000FF, 0xFFFFFFFF)
    assert low < middle < high
    assert mapped.palette[0] == low
    assert mapped.palette[-1] == high


def test_age_is_a_share_of_the_lifetime() -> None:
    ages, lifetimes = np.array([0.0, 1.0, 2.0]), np.array([1.0, 1.0, 4.0])
    share = look(color={"by": "age", "map": ["#000000", "#ffffff"]})
    young, old, half = colors(share, group(ages=ages, lifetimes=lifetimes))
    assert young < half < old


def test_what_is_not_a_number_has_the_first_colour() -> None:
    temperatures = np.array([np.nan, 10, 10])
    assert colors(look(color={"by": "temperature", **RAMP}), group(temperatures=temperatures))[0] == 0x000000FF

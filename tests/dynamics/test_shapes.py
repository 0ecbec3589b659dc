"""Every shape is filled evenly, wherever it lies and however it is turned."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pydantic import TypeAdapter
from scipy import stats

from particlecli.dynamics.random import Draws
from particlecli.dynamics.shapes import directions, perpendiculars, points
from particlecli.scene.groups import Aim, Shape

COUNT = 20_000
SURPRISING = 1e-3
CENTER = np.array([1.0, -2.0, 3.0])
AXIS = np.array([2.0, -1.0, 2.0]) / 3.0

Array = NDArray[np.float64]


def sampled(**shape: object) -> Array:
    """Points of a shape about CENTER, relative to it."""
    if shape["type"] != "line":
        shape["center"] = CENTER.tolist()
    parsed: Shape = TypeAdapter(Shape).validate_python(shape)
    return points(parsed, Draws(11, "shape", np.arange(COUNT))) - CENTER[:, None]


def uniform(values: Array, low: float = 0.0, high: float = 1.0) -> bool:
    return bool(stats.kstest(values, "uniform", args=(low, high - low)).pvalue > SURPRISING)


def about_axis(offsets: Array, axis: Array = AXIS) -> tuple[Array, Array, Array]:
    """Height along the axis, distance from it and angle about it, from an arbitrary direction."""
    height = axis @ offsets
    first = np.cross(axis, [0.36, 0.48, 0.8])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    return height, np.hypot(first @ offsets, second @ offsets), np.arctan2(second @ offsets, first @ offsets)


def test_a_point_is_a_point() -> None:
    assert (sampled(type="point") == 0).all()


def test_a_line_is_even_along_its_length() -> None:
    start, end = CENTER + AXIS, CENTER - 2 * AXIS
    offsets = sampled(type="line", start=start.tolist(), end=end.tolist())
    height, distance, _ = about_axis(offsets)
    assert distance.max() < 1e-12
    assert uniform(height, -2, 1)


def test_a_ring_is_even_around_its_axis() -> None:
    height, distance, angle = about_axis(sampled(type="ring", axis=AXIS.tolist(), radius=0.5))
    assert np.abs(height).max() < 1e-12
    assert np.abs(distance - 0.5).max() < 1e-12
    assert uniform(angle, -math.pi, math.pi)


def test_a_disc_is_even_over_its_area() -> None:
    height, distance, angle = about_axis(sampled(type="disc", axis=AXIS.tolist(), radius=0.5))
    assert np.abs(height).max() < 1e-12
    assert uniform((distance / 0.5) ** 2)
    assert uniform(angle, -math.pi, math.pi)
    assert abs(stats.spearmanr(distance, angle).statistic) < 0.03


def test_a_sphere_is_even_over_its_surface() -> None:
    offsets = sampled(type="sphere", radius=2.0)
    assert np.abs(np.linalg.norm(offsets, axis=0) - 2.0).max() < 1e-12
    height, _, angle = about_axis(offsets)
    assert uniform(height, -2, 2)
    assert uniform(angle, -math.pi, math.pi)


def test_a_ball_is_even_over_its_volume() -> None:
    offsets = sampled(type="ball", radius=2.0)
    radius = np.linalg.norm(offsets, axis=0)
    height, _, angle = about_axis(offsets / radius)
    assert uniform((radius / 2.0) ** 3)
    assert uniform(height, -1, 1)
    assert uniform(angle, -math.pi, math.pi)
    assert abs(stats.spearmanr(radius, height).statistic) < 0.03


def test_a_box_is_even_over_its_volume() -> None:
    offsets = sampled(type="box", size=[1.0, 2.0, 0.0])
    assert uniform(offsets[0], -0.5, 0.5)
    assert uniform(offsets[1], -1, 1)
    assert (offsets[2] == 0).all()
    assert abs(stats.spearmanr(offsets[0], offsets[1]).statistic) < 0.03


@pytest.mark.parametrize("spread", [1e-3, 25.0, 90.0, 180.0])
def test_directions_are_even_over_the_cap(spread: float) -> None:
    aim = Aim(axis=tuple(AXIS), spread=spread)
    unit = directions(aim, Draws(5, "aim", np.arange(COUNT)))
    assert np.abs(np.linalg.norm(unit, axis=0) - 1).max() < 1e-14
    # the chord to the axis' tip gives the height below it without cancellation, also in a narrow cone
    below = np.linalg.norm(unit - AXIS[:, None], axis=0) ** 2 / 2
    assert uniform(below / (2 * math.sin(math.radians(spread) / 2) ** 2))
    angle = about_axis(unit)[2]
    assert uniform(angle, -math.pi, math.pi)
    assert abs(stats.spearmanr(below, angle).statistic) < 0.03


def test_without_spread_all_go_along_the_axis() -> None:
    unit = directions(Aim(axis=tuple(AXIS)), Draws(5, "aim", np.arange(10)))
    assert (unit == np.reshape(Aim(axis=tuple(AXIS)).axis, (3, 1))).all()


coordinate = st.floats(-1, 1) | st.sampled_from([0.0, -0.0, 1e-9, -1e-9, 1e-160])


@settings(deadline=None)
@given(st.tuples(coordinate, coordinate, coordinate).filter(lambda v: math.hypot(*v) > 1e-100))
def test_perpendiculars_complete_a_right_handed_orthonormal_frame(vector: tuple[float, float, float]) -> None:
    axis = np.array(vector) / math.hypot(*vector)
    first, second = perpendiculars((float(axis[0]), float(axis[1]), float(axis[2])))
    frame = np.stack([first, second, axis])
    assert np.abs(frame @ frame.T - np.eye(3)).max() < 1e-14
    assert np.linalg.det(frame) > 0


@pytest.mark.parametrize("kind", ["line", "disc", "ring", "sphere", "ball", "box"])
def test_a_particle_s_point_does_not_depend_on_the_others(kind: str) -> None:
    sizes = {"line": {"start": [0, 0, 0], "end": [1, 2, 3]}, "box": {"size": [1, 2, 3]}}
    shape: Shape = TypeAdapter(Shape).validate_python({"type": kind, **sizes.get(kind, {"radius": 0.3})})
    aim = Aim(spread=30)
    whole = Draws(2, "a", np.arange(100))
    for first, last in ((0, 1), (1, 4), (4, 37), (37, 100)):
        part = Draws(2, "a", np.arange(first, last))
        assert (points(shape, whole)[:, first:last] == points(shape, part)).all()
        assert (directions(aim, whole)[:, first:last] == directions(aim, part)).all()

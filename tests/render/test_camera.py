from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from particlecli.render.camera import View, on_picture, views_of
from particlecli.scene.camera import Camera
from particlecli.scene.frames import CoordinateFrame

PLACES = st.tuples(*[st.floats(-50, 50)] * 3)


def view(**options: object) -> View:
    return View.of(Camera.model_validate({"position": (0, 0, 4), "look_at": (0, 0, 0), **options}), 64, 48)


def test_the_point_looked_at_is_in_the_middle() -> None:
    pixels, depths = view(look_at=(1, 2, -3), position=(4, 1, 5)).project(np.array([[1.0, 2.0, -3.0]]))
    assert pixels == pytest.approx(np.array([[31.5, 23.5]]))
    assert depths == pytest.approx([np.sqrt(9 + 1 + 64)])


def test_the_angle_of_view_spans_the_height() -> None:
    top = 4 * np.tan(np.radians(20))
    pixels, _ = view(field_of_view=40).project(np.array([[0, top, 0], [0, -top, 0]]))
    assert pixels[:, 1] == pytest.approx([-0.5, 47.5])


def test_right_is_right_and_up_is_up() -> None:
    pixels, _ = view().project(np.array([[0.1, 0.2, 0.0]]))
    assert pixels[0, 0] > 31.5
    assert pixels[0, 1] < 23.5


def test_points_behind_the_camera_have_no_pixel() -> None:
    pixels, depths = view().project(np.array([[0.0, 0.0, 5.0], [0.0, 0.0, 4.0]]))
    assert np.isnan(pixels).all()
    assert depths == pytest.approx([-1.0, 0.0])


@given(PLACES, PLACES, st.floats(5, 120))
def test_a_point_lies_on_the_ray_through_its_pixel(
    position: tuple[float, float, float], point: tuple[float, float, float], angle: float
) -> None:
    if np.hypot(position[0] - 60, position[2] - 60) < 1e-3:
        return
    seen = view(position=position, look_at=(60, 0, 60), field_of_view=angle)
    (pixel,), (depth,) = seen.project(np.array([point]))
    if not depth > 0.01 or not np.all(np.abs(pixel) < 1e5):
        return
    corner, across, down = seen.rays()[3], seen.right / seen.focal, -seen.up / seen.focal
    ray = corner + pixel[0] * across + pixel[1] * down
    assert seen.position + depth * ray == pytest.approx(np.array(point), abs=1e-6)


def test_a_draft_sees_the_same_as_the_final_picture() -> None:
    camera = Camera(position=(1, 2, 5), look_at=(0, 1, 0))
    points = np.random.default_rng(1).uniform(-1, 1, (20, 3))
    draft, _ = View.of(camera, 320, 180).project(points)
    final, _ = View.of(camera, 1280, 720).project(points)
    assert (draft + 0.5) * 4 == pytest.approx(final + 0.5)


def test_a_camera_on_a_path_is_where_its_expressions_say() -> None:
    camera = Camera.model_validate({"position": ["4*sin(t)", 0, "4*cos(t)"], "look_at": [0, 0, "t"]})
    views = views_of(camera, 64, 48, {})
    assert views(0.5).position == pytest.approx([4 * np.sin(0.5), 0, 4 * np.cos(0.5)])
    assert views(0.5).project(np.array([[0, 0, 0.5]]))[0] == pytest.approx(np.array([[31.5, 23.5]]))


def test_a_camera_that_rests_has_one_view() -> None:
    views = views_of(Camera(), 64, 48, {})
    assert views(0.0) is views(1.0)


def test_a_camera_rides_on_a_frame() -> None:
    quarter = CoordinateFrame.model_validate(
        {"translate": [1, 0, 0], "rotate": {"axis": [0, 0, 1], "angle": f"{np.pi / 2}*t"}, "scale": 2}
    )
    camera = Camera.model_validate({"position": [0, 0, 4], "look_at": [0, 0, 0], "frame": "arm"})
    there = View.of(camera, 64, 48, {"arm": quarter}, 1.0)
    assert there.position == pytest.approx([1, 0, 8])
    assert there.up == pytest.approx([-1, 0, 0], abs=1e-12)
    assert there.distance == pytest.approx(8)


def test_an_orthographic_camera_shows_all_as_large_as_at_the_point_looked_at() -> None:
    flat, deep = view(projection="orthographic"), view()
    points = np.array([[0.5, 0.3, 0.0], [0.5, 0.3, 2.0], [0.5, 0.3, -30.0]])
    pixels, depths = flat.project(points)
    assert pixels == pytest.approx(np.repeat(deep.project(points[:1])[0], 3, axis=0))
    assert depths == pytest.approx([4, 2, 34])
    offset = np.array([[0.01, 0.0, 0.02]] * 3)
    assert on_picture(points[:2], offset[:2], flat) == pytest.approx([flat.focal * 0.01 / 4] * 2)


def test_rays_of_an_orthographic_camera_meet_what_is_on_their_pixel() -> None:
    flat = view(projection="orthographic", position=(3, 2, 4))
    point = np.array([0.4, -0.2, 1.0])
    (pixel,), (depth,) = flat.project(point[None])
    start, ray = (flat.rays()[k] + pixel[0] * flat.rays()[k + 1] + pixel[1] * flat.rays()[k + 2] for k in (0, 3))
    assert flat.position + start + depth * ray == pytest.approx(point)

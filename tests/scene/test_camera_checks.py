from __future__ import annotations

import pytest

from particlecli.scene.camera_checks import camera_problems
from particlecli.scene.model import Scene


@pytest.mark.parametrize(
    ("camera", "path", "message"),
    [
        ({"frame": "arm"}, ("camera", "frame"), "there is no frame"),
        ({"position": [0, "1/(t-1)", 3]}, ("camera", "position", 1), "not finite"),
        ({"position": [0, 0, "2-2*t"], "look_at": [0, 0, 0]}, ("camera", "look_at"), "where the camera is at t = 1 s"),
        ({"position": [0, 2, "1-t"], "look_at": [0, 0, 0]}, ("camera", "up"), "the camera looks in at t = 1 s"),
    ],
)
def test_cameras_that_do_not_see_are_refused(camera: dict[str, object], path: tuple[object, ...], message: str) -> None:
    scene = Scene.model_validate({"duration": 2, "camera": camera})
    ((found, told),) = camera_problems(scene)
    assert found == path
    assert message in told


def test_a_camera_in_orbit_is_fine() -> None:
    orbit = {"position": ["5*sin(t)", 1.5, "5*cos(t)"], "look_at": [0, 1, 0]}
    assert list(camera_problems(Scene.model_validate({"duration": 9, "camera": orbit}))) == []

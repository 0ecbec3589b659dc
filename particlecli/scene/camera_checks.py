"""Checks of the camera: whether it looks somewhere at all times of the scene."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from particlecli.scene.frame_checks import SAMPLES, over_time
from particlecli.scene.group_checks import Found, missing_frame
from particlecli.scene.model import Scene

LEVEL = 1e-6
"""Sine of the angle between what is up and the line of sight that leaves a picture no direction."""


def camera_problems(scene: Scene) -> Iterator[Found]:
    """What is wrong with a camera that moves."""
    camera = scene.camera
    yield from missing_frame(scene, ("camera", "frame"), camera.frame)
    paths = {}
    for key in ("position", "look_at"):
        path = np.stack([over_time(each, scene.duration) for each in getattr(camera, key)], axis=1)
        if not np.isfinite(path).all():
            axis = int(np.argmin(np.isfinite(path).all(axis=0)))
            yield ("camera", key, axis), "is not finite at all times of the scene"
            return
        paths[key] = path
    line = paths["look_at"] - paths["position"]
    length = np.linalg.norm(line, axis=1)
    side = np.linalg.norm(np.cross(line, camera.up), axis=1)
    if (length == 0).any():
        yield ("camera", "look_at"), f"is where the camera is at t = {_when(scene, length == 0)}"
    elif (side <= LEVEL * length).any():
        when = _when(scene, side <= LEVEL * length)
        yield ("camera", "up"), f"is the direction the camera looks in at t = {when}; choose another"


def _when(scene: Scene, found: NDArray[np.bool_]) -> str:
    return f"{int(np.argmax(found)) / (SAMPLES - 1) * scene.duration:.3g} s"

"""Checks of coordinate frames: that they make up a tree, and stay finite and of some size."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from particlecli.scene.document import KeyPath
from particlecli.scene.expression import Expression
from particlecli.scene.frames import CoordinateFrame
from particlecli.scene.messages import suggestion
from particlecli.scene.model import Scene

SAMPLES = 1001
"""Instants at which expressions of time are tried."""


def frame_problems(scene: Scene) -> Iterator[tuple[KeyPath, str]]:
    """What is wrong with the coordinate frames of a scene: for each the path of a key, and what to do."""
    for name, frame in scene.frames.items():
        if frame.parent is not None and frame.parent not in scene.frames:
            message = f'there is no frame "{frame.parent}"{suggestion(frame.parent, scene.frames)}'
            yield ("frames", name, "parent"), message
        elif _rides_on_itself(scene, name):
            yield ("frames", name, "parent"), f'"{name}" rides on itself; one of these frames must ride on the world'
        for key, expression in _expressions(frame):
            values = over_time(expression, scene.duration)
            if not np.isfinite(values).all():
                yield ("frames", name, *key), "is not finite at all times of the scene"
            elif key == ("scale",) and values.min() <= 0:
                yield ("frames", name, "scale"), "must be positive at all times"


def _rides_on_itself(scene: Scene, name: str) -> bool:
    parent = scene.frames[name].parent
    for _ in scene.frames:
        if parent == name:
            return True
        parent = scene.frames[parent].parent if parent in scene.frames else None
    return False


def _expressions(frame: CoordinateFrame) -> Iterator[tuple[KeyPath, Expression]]:
    for axis, component in enumerate(frame.translate):
        yield ("translate", axis), component
    if frame.rotate is not None:
        yield ("rotate", "angle"), frame.rotate.angle
    yield ("scale",), frame.scale


def over_time(expression: Expression, duration: float) -> np.ndarray:
    """Its values at SAMPLES instants from 0 to the duration, s."""
    times = np.linspace(0.0, duration, SAMPLES)
    with np.errstate(all="ignore"):
        return np.broadcast_to(expression.evaluate({"t": times}), times.shape)

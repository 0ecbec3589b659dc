"""Coordinate frames as recordings have them: where each is in the one it rides on."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from particlecli.scene.expression import Expression
from particlecli.scene.frames import CoordinateFrame
from particlecli.sinks.recording import layout

Doubles = NDArray[np.float64]


def entities(frames: Mapping[str, CoordinateFrame]) -> dict[str, CoordinateFrame]:
    """The frames by entity: the names from the world to each, so that poses compose along the path."""
    return {entity(frames, name): frame for name, frame in frames.items()}


def entity(frames: Mapping[str, CoordinateFrame], name: str) -> str:
    """The entity of a frame, below the one that it rides on."""
    parent = frames[name].parent
    return f"{layout.FRAMES if parent is None else entity(frames, parent)}/{name}"


def pose(frame: CoordinateFrame, time: float) -> tuple[Doubles, Doubles, Doubles]:
    """Translation in m, quaternion (x, y, z, w) and scale by axis, in the parent; shapes (1, 3), (1, 4), (1, 3)."""
    translation = [_number(component, time) for component in frame.translate]
    quaternion = [0.0, 0.0, 0.0, 1.0]
    if frame.rotate is not None:
        half = 0.5 * _number(frame.rotate.angle, time)
        quaternion = [*(math.sin(half) * component for component in frame.rotate.axis), math.cos(half)]
    return np.array([translation]), np.array([quaternion]), np.full((1, 3), _number(frame.scale, time))


def _number(expression: Expression, time: float) -> float:
    return float(expression.evaluate({"t": time}))

"""The boxes that shapes and layouts fit into."""

from __future__ import annotations

import math
from collections.abc import Iterable

from particlecli.scene.shapes import (
    BallShape,
    BoxShape,
    DiscShape,
    GridLayout,
    HairLayout,
    LatticeLayout,
    Layout,
    LineLayout,
    LineShape,
    PointShape,
    RingShape,
    Shape,
    SphereShape,
)
from particlecli.scene.types import Vector3


def extent(shape: Shape | Layout) -> tuple[Vector3, Vector3]:
    """The corners, m, of the smallest box around a shape or layout: smallest and largest coordinates."""
    if isinstance(shape, (LineShape, LineLayout)):
        ends = list(zip(shape.start, shape.end, strict=True))
        return _vector(map(min, ends)), _vector(map(max, ends))
    reach = _reach(shape)
    low = _vector(middle - half for middle, half in zip(shape.center, reach, strict=True))
    high = _vector(middle + half for middle, half in zip(shape.center, reach, strict=True))
    return low, high


def _reach(
    shape: PointShape
    | DiscShape
    | RingShape
    | SphereShape
    | BallShape
    | BoxShape
    | GridLayout
    | HairLayout
    | LatticeLayout,
) -> Vector3:
    match shape:
        case PointShape():
            return 0.0, 0.0, 0.0
        case SphereShape() | BallShape():
            return shape.radius, shape.radius, shape.radius
        case HairLayout():
            return (shape.radius + shape.length,) * 3
        case DiscShape() | RingShape():
            return _vector(shape.radius * math.sqrt(max(0.0, 1.0 - along**2)) for along in shape.axis)
        case BoxShape() | LatticeLayout():
            return _vector(edge / 2 for edge in shape.size)
        case GridLayout():
            spaces = zip(shape.counts, shape.spacing, strict=True)
            return _vector((count - 1) * spacing / 2 for count, spacing in spaces)


def _vector(components: Iterable[float]) -> Vector3:
    x, y, z = components
    return x, y, z

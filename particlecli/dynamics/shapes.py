"""Points spread evenly over the shapes of emitters, and directions spread evenly over a cap."""

from __future__ import annotations

import math

import numpy as np

from particlecli.dynamics.random import Array, Draw, Draws
from particlecli.scene.groups import Aim
from particlecli.scene.shapes import (
    BallShape,
    BoxShape,
    DiscShape,
    LineShape,
    PointShape,
    RingShape,
    Shape,
    SphereShape,
)
from particlecli.scene.types import Vector3


def points(shape: Shape, draws: Draws) -> Array:
    """Shape (3, n), m: for each particle a point of the shape, evenly over its length, area or volume."""
    match shape:
        case PointShape():
            offsets = np.zeros((3, len(draws)))
        case LineShape():
            return _between(shape.start, shape.end, draws.uniform(Draw.POSITION_1))
        case RingShape():
            offsets = _around(shape.axis, shape.radius, 0.0, draws.uniform(Draw.POSITION_1))
        case DiscShape():
            radii = shape.radius * np.sqrt(draws.uniform(Draw.POSITION_2))
            offsets = _around(shape.axis, radii, 0.0, draws.uniform(Draw.POSITION_1))
        case SphereShape():
            offsets = _directions(draws) * shape.radius
        case BallShape():
            offsets = _directions(draws)
            offsets *= shape.radius * np.cbrt(draws.uniform(Draw.POSITION_3))
        case BoxShape():
            axes = Draw.POSITION_1, Draw.POSITION_2, Draw.POSITION_3
            offsets = np.stack([draws.uniform(axis) for axis in axes])
            offsets -= 0.5
            offsets *= np.reshape(shape.size, (3, 1))
    offsets += np.reshape(shape.center, (3, 1))
    return offsets


def directions(aim: Aim, draws: Draws) -> Array:
    """Shape (3, n): unit vectors, evenly over the spherical cap of half angle `spread` about the axis.

    By Archimedes' theorem the height h = 1 − cos θ below the top of the cap is uniform; measured from there,
    the narrowest cone keeps all its digits.
    """
    if aim.spread == 0:
        return np.repeat(np.reshape(aim.axis, (3, 1)), len(draws), axis=1)
    height = 2.0 * math.sin(math.radians(aim.spread) / 2) ** 2 * draws.uniform(Draw.DIRECTION_1)
    return _around(aim.axis, np.sqrt(height * (2.0 - height)), 1.0 - height, draws.uniform(Draw.DIRECTION_2))


def perpendiculars(axis: Vector3) -> tuple[Array, Array]:
    """Two unit vectors that form a right-handed orthonormal frame with a unit axis, in this order; shape (3,).

    Precise for every direction: Duff et al., "Building an orthonormal basis, revisited" (JCGT 6, 2017).
    """
    x, y, z = axis
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return np.array([1.0 + sign * x * x * a, sign * b, -sign * x]), np.array([b, sign + y * y * a, -y])


def _around(axis: Vector3, radii: Array | float, along: Array | float, turns: Array) -> Array:
    """Shape (3, n): points at distances `radii` from the axis, `along` it, after so many `turns` about it."""
    first, second = perpendiculars(axis)
    angles = 2.0 * math.pi * turns
    right, up = radii * np.cos(angles), radii * np.sin(angles)
    return np.stack([first[i] * right + second[i] * up + axis[i] * along for i in range(3)])


def _directions(draws: Draws) -> Array:
    """Shape (3, n): unit vectors, evenly over the sphere."""
    share = draws.uniform(Draw.POSITION_1)
    sines = 2.0 * np.sqrt(share * (1.0 - share))
    return _around((0.0, 0.0, 1.0), sines, 1.0 - 2.0 * share, draws.uniform(Draw.POSITION_2))


def _between(start: Vector3, end: Vector3, share: Array) -> Array:
    return np.stack([(1.0 - share) * low + share * high for low, high in zip(start, end, strict=True)])

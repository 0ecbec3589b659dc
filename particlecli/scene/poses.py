"""Poses of coordinate frames at instants, with their rates of change: in NumPy, in double precision.

Symbols: a pose takes x to T + s R x; T translation, m; R rotation; s scale; a dot is the rate of change, per second.
Poses compose along a chain of frames: s = s₁ s₂, R = R₁ R₂, T = T₁ + s₁ R₁ T₂, and their rates by the product rule.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from particlecli.scene.expression import Expression
from particlecli.scene.frames import Chain, CoordinateFrame, chain
from particlecli.scene.planes import Plane
from particlecli.scene.types import Vector3

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Poses:
    """A frame's pose at n instants.

    Attributes:
        scale, scaling: s and its rate, shape (n,).
        rotation, turning: R and its rate, shape (n, 3, 3).
        translation, velocity: T and its rate, shape (n, 3), m and m/s.
    """

    scale: Array
    rotation: Array
    translation: Array
    scaling: Array
    turning: Array
    velocity: Array

    @classmethod
    def of(cls, ride: Chain, times: Array) -> Poses:
        """The poses of the last frame of a chain in the world at times, shape (n,), s.

        The poses at a single time serve any number of points.
        """
        n = len(times)
        still = np.zeros((n, 3, 3))
        pose = cls(
            np.ones(n), np.broadcast_to(np.eye(3), (n, 3, 3)), np.zeros((n, 3)), np.zeros(n), still, np.zeros((n, 3))
        )
        for frame in ride:
            pose = pose.carrying(_local(frame, times))
        return pose

    def carrying(self, inner: Poses) -> Poses:
        """The poses in the world of a frame whose poses in this one are given."""
        lever = _turned(self.rotation, inner.translation)
        sweep = _turned(self.turning, inner.translation) + _turned(self.rotation, inner.velocity)
        return Poses(
            scale=self.scale * inner.scale,
            rotation=self.rotation @ inner.rotation,
            translation=self.translation + self.scale[:, None] * lever,
            scaling=self.scaling * inner.scale + self.scale * inner.scaling,
            turning=self.turning @ inner.rotation + self.rotation @ inner.turning,
            velocity=self.velocity + self.scaling[:, None] * lever + self.scale[:, None] * sweep,
        )

    def points(self, local: Array) -> Array:
        """Where points given in the frame are in the world, m; both of shape (3, n), one for each pose."""
        return (self.translation + self.scale[:, None] * _turned(self.rotation, local.T)).T

    def local(self, points: Array) -> Array:
        """Where points of the world are in the frame, m; both of shape (3, n), one for each pose."""
        back = np.swapaxes(self.rotation, 1, 2)
        return (_turned(back, points.T - self.translation) / self.scale[:, None]).T

    def velocities(self, local: Array) -> Array:
        """How fast points that are fixed in the frame move in the world, m/s; both of shape (3, n)."""
        turned, turning = _turned(self.rotation, local.T), _turned(self.turning, local.T)
        return (self.velocity + self.scaling[:, None] * turned + self.scale[:, None] * turning).T

    def directions(self, local: Array) -> Array:
        """Vectors given in the frame as they are in the world, turned but of the same length; shape (3, n)."""
        return _turned(self.rotation, local.T).T


def planes_at(planes: Iterable[Plane], frames: Mapping[str, CoordinateFrame], time: float) -> list[Plane]:
    """Planes as they stand in the world at a time, s."""
    return [_standing(plane, chain(frames, plane.frame), time) for plane in planes]


def _standing(plane: Plane, ride: Chain, time: float) -> Plane:
    if not ride:
        return plane
    pose = Poses.of(ride, np.array([time]))
    point, normal = pose.points(np.array(plane.point)[:, None]), pose.directions(np.array(plane.normal)[:, None])
    changes = {"point": tuple(point[:, 0].tolist()), "normal": tuple(normal[:, 0].tolist()), "frame": None}
    return plane.model_copy(update=changes)


def _turned(rotation: Array, vectors: Array) -> Array:
    return np.asarray((rotation @ vectors[..., None])[..., 0], np.float64)


def _local(frame: CoordinateFrame, times: Array) -> Poses:
    """The poses of a frame in its parent."""
    scale, scaling = _followed(frame.scale, times)
    along = [_followed(component, times) for component in frame.translate]
    rotation, turning = _rotation(frame, times)
    return Poses(
        scale=scale,
        rotation=rotation,
        translation=np.stack([value for value, _ in along], axis=1),
        scaling=scaling,
        turning=turning,
        velocity=np.stack([rate for _, rate in along], axis=1),
    )


def _rotation(frame: CoordinateFrame, times: Array) -> tuple[Array, Array]:
    """R and its rate by Rodrigues' formula, R = c I + s [a]× + (1 − c) a aᵀ; shapes (n, 3, 3)."""
    n = len(times)
    if frame.rotate is None:
        return np.broadcast_to(np.eye(3), (n, 3, 3)), np.zeros((n, 3, 3))
    angle, rate = (values[:, None, None] for values in _followed(frame.rotate.angle, times))
    cross, square = _cross(frame.rotate.axis), np.outer(frame.rotate.axis, frame.rotate.axis)
    flat = np.eye(3) - square
    rotation = np.cos(angle) * flat + np.sin(angle) * cross + square
    return rotation, rate * (np.cos(angle) * cross - np.sin(angle) * flat)


def _cross(a: Vector3) -> Array:
    """The matrix of x ↦ a × x."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _followed(expression: Expression, times: Array) -> tuple[Array, Array]:
    """An expression of t and its rate of change at times, shapes (n,)."""
    with np.errstate(all="ignore"):
        value = np.broadcast_to(expression.evaluate({"t": times}), times.shape)
        rate = np.broadcast_to(expression.derivative("t").evaluate({"t": times}), times.shape)
    return value.astype(np.float64), rate.astype(np.float64)

"""The camera as NumPy mathematics: where a point of the world lands in the picture."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from particlecli.scene.camera import Camera
from particlecli.scene.frames import CoordinateFrame, chain
from particlecli.scene.poses import Poses

Floats = NDArray[np.floating[Any]]
Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class View:
    """A camera at a resolution, at an instant.

    Pixel coordinates have x to the right and y downwards; the middle of the first pixel is (0, 0). A point a m to
    the right of the optical axis at depth d m lands focal · a / (slope · d + level) pixels from the middle.

    Attributes:
        position: shape (3,), m.
        right, up, forward: shape (3,), orthonormal axes of the camera.
        focal: distance of the picture plane, pixels.
        width, height: pixels.
        distance: from the position to the point looked at, m; the scale of what is seen.
        slope, level: 1 and 0 in perspective; 0 and the distance, m, where the projection is orthographic.
        aperture: diameter of the lens, m; 0 where all is sharp.
        focus: distance that is sharp, m.
    """

    position: Doubles
    right: Doubles
    up: Doubles
    forward: Doubles
    focal: float
    width: int
    height: int
    distance: float
    slope: float = 1.0
    level: float = 0.0
    aperture: float = 0.0
    focus: float = 1.0

    @classmethod
    def of(
        cls, camera: Camera, width: int, height: int, frames: Mapping[str, CoordinateFrame] = MappingProxyType({}),
        time: float = 0.0,
    ) -> View:  # fmt: skip
        """The scene's camera at a resolution of its own; the vertical angle of view stays the same.

        Args:
            camera: the scene's.
            width, height: of the picture, pixels.
            frames: the scene's coordinate frames, which the camera may ride on.
            time: when, s.
        """
        position, target, overhead = _placed(camera, frames, time)
        line = target - position
        distance = float(np.linalg.norm(line))
        forward = line / distance
        right = np.cross(forward, overhead)
        right /= np.linalg.norm(right)
        focal = 0.5 * height / math.tan(math.radians(camera.field_of_view) / 2)
        up = np.cross(right, forward)
        flat = camera.projection == "orthographic"
        lens = camera.depth_of_field
        return cls(
            position, right, up, forward, focal, width, height, distance,
            slope=0.0 if flat else 1.0,
            level=distance if flat else 0.0,
            aperture=lens.aperture if lens else 0.0,
            focus=(lens.focus if lens else None) or distance,
        )  # fmt: skip

    @property
    def center(self) -> tuple[float, float]:
        """Pixel coordinates of the optical axis."""
        return (self.width - 1) / 2, (self.height - 1) / 2

    def project(self, points: Floats) -> tuple[Doubles, Doubles]:
        """Pixel coordinates and depths of points.

        Args:
            points: shape (n, 3), m.

        Returns:
            Pixels, shape (n, 2), NaN for points that are not in front of the camera; and depths along
            the optical axis, shape (n,), m.
        """
        offset = np.asarray(points, dtype=np.float64) - self.position
        depth = offset @ self.forward
        ahead = np.where(depth > 0, self.slope * depth + self.level, np.nan)
        x = self.center[0] + self.focal * (offset @ self.right) / ahead
        y = self.center[1] - self.focal * (offset @ self.up) / ahead
        return np.stack([x, y], axis=-1), depth

    def rays(self, step: int = 1) -> Doubles:
        """The rays through pixels, each `step` pixels on: where they start and where they go, shape (6, 3).

        The ray through pixel (x, y) starts, relative to the position, at row 0 + x · row 1 + y · row 2, and has
        the direction row 3 + x · row 4 + y · row 5, of depth 1.
        """
        x, y = self.center
        corner = self.up * (y / self.focal) - self.right * (x / self.focal)
        lateral = np.stack([corner, self.right * (step / self.focal), self.up * (-step / self.focal)])
        ahead = np.stack([self.forward, np.zeros(3), np.zeros(3)])
        return np.concatenate([self.level * lateral, self.slope * lateral + ahead])


def views_of(camera: Camera, width: int, height: int, frames: Mapping[str, CoordinateFrame]) -> Callable[[float], View]:
    """The view at each instant, s; one and the same object at all where the camera rests."""
    if camera.moves:
        return lambda time: View.of(camera, width, height, frames, time)
    still = View.of(camera, width, height)
    return lambda _: still


def _placed(camera: Camera, frames: Mapping[str, CoordinateFrame], time: float) -> tuple[Doubles, Doubles, Doubles]:
    """Position, point looked at and what is up, in the world, shapes (3,)."""
    position, target = (
        np.array([float(each.evaluate({"t": time})) for each in point]) for point in (camera.position, camera.look_at)
    )
    overhead = np.array(camera.up)
    if camera.frame is None:
        return position, target, overhead
    pose = Poses.of(chain(frames, camera.frame), np.array([time]))
    position, target = (pose.points(point[:, None])[:, 0] for point in (position, target))
    return position, target, pose.directions(overhead[:, None])[:, 0]


def on_picture(positions: Doubles, offset: Doubles, view: View) -> Doubles:
    """How long small offsets of particles are on the picture, pixels; NaN where a particle is not seen on it.

    Args:
        positions: where the particles are, shape (…, 3), m.
        offset: how far they are off, shape (…, 3), m.
        view: the camera.
    """
    line = positions - view.position
    depth = line @ view.forward
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = view.focal / np.where(depth > 0, view.slope * depth + view.level, np.nan)
        nearer = view.slope * (offset @ view.forward) / view.focal
        squares = np.zeros(depth.shape)
        seen = np.ones(depth.shape, dtype=bool)
        for axis, size in ((view.right, view.width), (view.up, view.height)):
            place = scale * (line @ axis)
            squares += (scale * (offset @ axis - place * nearer)) ** 2
            seen &= np.abs(place) <= size / 2
    return np.where(seen, np.sqrt(squares), np.nan)

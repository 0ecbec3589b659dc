"""Planes drawn as ground: a softly lit surface that fades into the sky, mirrors the glow and is lit by it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from particlecli.render.arena import PACK
from particlecli.render.arrays import vec3
from particlecli.render.batch import Batch
from particlecli.render.camera import View
from particlecli.render.colour import from_hex
from particlecli.render.ground_kernels import add_pool, lay_ground
from particlecli.render.painter import Painter
from particlecli.render.particles import Particles, room_of
from particlecli.render.pyramid import Pyramid, clear_together
from particlecli.render.shot import mirror_row
from particlecli.render.sprites import POOLED, SEEN
from particlecli.scene.look import Ground
from particlecli.scene.model import Scene
from particlecli.scene.planes import Plane
from particlecli.scene.poses import planes_at

Doubles = NDArray[np.float64]
Floats = NDArray[np.float32]

SEEN_LINES = 180
"""What is seen in the ground is drawn with about so many lines, whatever the picture has."""

CELLS = 256
"""Cells along each side of a plane's grid of light."""

GRID_SIZE = 5.0
"""Side of that grid, in distances from the camera to the point it looks at."""

POOL_HALO = 0.6
"""Share of the light on the ground that falls far from the foot of a particle."""

HAZE = 5.0
"""Distance at which the ground fades into the sky, in distances from the camera to the point it looks at."""

SPREAD = 0.25
"""Angle over which a surface of roughness 1 spreads what it mirrors, radians."""


VISIBLE = 1 / 1024
"""Planes that cover less of every pixel are not drawn."""


@dataclass(frozen=True)
class Facing:
    """A plane that the camera sees the front of.

    Attributes:
        normal: shape (3,).
        height: of the camera above it, m.
        cover: shape (height, width), how much of each pixel it covers, less the haze.
    """

    normal: Doubles
    height: float
    cover: Floats


def planes_of(scene: Scene) -> Callable[[float], Sequence[Plane]]:
    """The planes to draw, as they stand at each instant, s; one and the same list at all where they rest."""
    planes = scene.planes if scene.look.ground.visible else ()
    if any(plane.frame is not None for plane in planes):
        return lambda time: planes_at(planes, scene.frames, time)
    return lambda _: planes


def facing_planes(planes: Sequence[Plane], view: View, haze: float | None) -> list[Facing]:
    """The planes whose front the camera sees, each where it is not behind another."""
    normals, heights = _distinct(planes, view)
    reach = haze or HAZE * view.distance
    found = []
    for place, (normal, height) in enumerate(zip(normals, heights, strict=True)):
        if height <= 0:
            continue
        cover = _positive(*_sinking(view.rays(), normal), view)
        for other, (cut, above) in enumerate(zip(normals, heights, strict=True)):
            if other != place:
                cover *= _side(normal, height, cut, above, view)
        rows = np.flatnonzero(cover.any(axis=1))
        if len(rows):
            seen = slice(int(rows[0]), int(rows[-1]) + 1)
            cover[seen] *= _clear(normal, height, view, reach, seen)
        found.append(Facing(normal, height, cover))
    overlap: Floats = np.maximum(np.sum([plane.cover for plane in found], axis=0), np.float32(1.0))
    apart = [Facing(plane.normal, plane.height, plane.cover / overlap) for plane in found]
    return [plane for plane in apart if (plane.cover > VISIBLE).any()]


def _sinking(rays: Doubles, normal: Doubles) -> tuple[float, float, float]:
    """How fast rays approach a plane: at the first pixel, and the change from one to the next across and down."""
    first, across, down = (-(rays[3:] @ normal)).tolist()
    return first, across, down


def _side(normal: Doubles, height: float, cut: Doubles, above: float, view: View) -> Floats:
    """Share of each pixel whose rays meet a plane (normal, height of the camera above it) over another.

    The ray o + s d meets the plane n, h at s = (h + n·o) / −n·d; that is over the plane m, k where
    (k + m·o)(−n·d) + (h + n·o)(m·d) > 0. As o or d is the same for all pixels, this is linear on the picture:
    horizons and the lines where planes meet are straight.
    """
    rays = view.rays()

    def over(x: int, y: int) -> float:
        start, ray = (rays[first] + x * rays[first + 1] + y * rays[first + 2] for first in (0, 3))
        return float(-(above + cut @ start) * (normal @ ray) + (height + normal @ start) * (cut @ ray))

    first = over(0, 0)
    return _positive(first, over(1, 0) - first, over(0, 1) - first, view)


def _positive(first: float, across: float, down: float, view: View) -> Floats:
    """Share of each pixel where a linear function of the place is positive, shape (height, width)."""
    slope = max(math.hypot(across, down), 1e-12)
    return np.clip(_linear((0.5 + first / slope, across / slope, down / slope), view), 0.0, 1.0)


def _linear(function: Sequence[float], view: View, rows: slice = slice(None)) -> Floats:
    """A linear function of the place on the picture: its value at the first pixel, and the changes across and down."""
    first, across, down = function
    x = (first + across * np.arange(view.width)).astype(np.float32)
    return x + (down * np.arange(view.height)[rows]).astype(np.float32)[:, None]


def _clear(normal: Doubles, height: float, view: View, reach: float, rows: slice) -> Floats:
    """What haze leaves of a plane, exp(−(way/reach)²), in rows of the picture; the way is along the ray of each pixel.

    With rays o + s d it is |d| (h + n·o) / −n·d long.
    """
    rays = view.rays()
    falling: Floats | np.float32 = np.float32(height)
    if rays[:3].any():
        falling = _linear((rays[:3] @ normal).tolist(), view, rows) + falling
    clear = falling / np.maximum(_linear(_sinking(rays, normal), view, rows), np.float32(1e-9))
    clear *= clear
    squares = _linear(rays[3:, 0].tolist(), view, rows) ** 2
    for axis in (1, 2):
        lengths = _linear(rays[3:, axis].tolist(), view, rows)
        lengths *= lengths
        squares += lengths
    clear *= squares
    clear *= np.float32(-1.0 / reach**2)
    return np.asarray(np.exp(clear, out=clear), np.float32)


def _distinct(planes: Sequence[Plane], view: View) -> tuple[list[Doubles], list[float]]:
    """Normals, and heights of the camera, of planes that do not coincide."""
    normals: list[Doubles] = []
    heights: list[float] = []
    for plane in planes:
        normal = np.array(plane.normal)
        height = float(normal @ (view.position - np.array(plane.point)))
        if not any(
            np.allclose(normal, known) and np.isclose(height, above)
            for known, above in zip(normals, heights, strict=True)
        ):
            normals.append(normal)
            heights.append(height)
    return normals, heights


def sizes(width: int, height: int) -> list[tuple[int, int]]:
    """Sizes of the pictures that a plane needs: of what is seen on it, and of its grid of light."""
    step = _step(height)
    return [(-(-width // step), -(-height // step)), (CELLS, CELLS)]


class GroundPlane:
    """One plane as ground; adds what is seen on it to a picture."""

    def __init__(self, facing: Facing, ground: Ground, view: View, seen: Pyramid, pool: Pyramid) -> None:
        """`seen` and `pool`, side by side, have the `sizes` for this view; planes may share them."""
        self._step = _step(view.height)
        self._rays = view.rays(self._step).astype(np.float32)
        self._albedo = vec3(*from_hex(ground.color))
        self._mirror = mirror_of(facing, ground, view, CELLS)
        self._cover = np.ascontiguousarray(facing.cover, np.float32)
        rows = np.flatnonzero((facing.cover > 0).any(axis=1))
        self._rows = int(rows[0]), int(rows[-1]) + 1
        self._seen, self._pool = seen, pool
        self._counter = np.zeros(1, np.int32)

    def add(self, groups: Sequence[tuple[Painter, Particles]], colors: Floats, light: Pyramid) -> None:
        """Add what the plane mirrors and throws back of the groups' light to the picture's level 0.

        `colors` has the tables of all tints.
        """
        if not any(particles.count for _, particles in groups):
            return
        seen, pool = self._seen, self._pool
        clear_together(seen, pool)
        batch = Batch({SEEN: seen, POOLED: pool}, colors, room_of(particles for _, particles in groups))
        for painter, particles in groups:
            painter.reflect(particles, batch, self._mirror, 1 / self._step, POOL_HALO)
        batch.draw()
        seen.collapse(onto=0)
        pool.collapse(onto=0)
        level, grid, picture = seen.levels[0], pool.levels[0], light.levels[0]
        add_pool(
            light.arena.light, level.origin, level.pitch, level.width, level.height,
            grid.origin, grid.pitch, float(CELLS), self._mirror, self._albedo, self._rays,
        )  # fmt: skip
        lay_ground(
            light.arena.light, light.arena.rows, self._counter,
            picture.origin, picture.pitch, *self._rows, picture.width,
            level.origin, level.pitch, level.width, self._step, self._cover,
        )  # fmt: skip


def _step(height: int) -> int:
    """Pixels to a pixel of what is seen on the ground."""
    return max(1, height // SEEN_LINES)


def mirror_of(facing: Facing, ground: Ground, view: View, cells: int) -> NDArray[np.float32]:
    """The plane for kernels, with a grid of `cells` squared around the foot of the point that the camera looks at."""
    normal = facing.normal
    along = view.right - (view.right @ normal) * normal
    if np.linalg.norm(along) < 1e-6:
        along = view.up - (view.up @ normal) * normal
    along = along / np.linalg.norm(along)
    across = np.cross(normal, along)
    side = GRID_SIZE * view.distance
    middle = view.distance * view.forward
    foot = middle - (facing.height + middle @ normal) * normal
    return mirror_row(
        normal=normal,
        height=facing.height,
        origin=foot - 0.5 * side * (along + across),
        along=along,
        across=across,
        cells=cells / side,
        roughness=SPREAD * ground.roughness,
        strength=ground.reflection,
    )


def coverage(planes: Sequence[Facing], view: View) -> Floats:
    """How much of each pixel is ground, shape (height, width filled up to whole packs)."""
    cover = np.zeros((view.height, view.width + -view.width % PACK), np.float32)
    for plane in planes:
        cover[:, : view.width] += plane.cover
    return np.minimum(cover, np.float32(1.0))

"""Renderer: frames to pictures, as a scene's camera and look say."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from particlecli import runtime
from particlecli.frame import Frame
from particlecli.render.arena import PACK
from particlecli.render.arrays import vec4
from particlecli.render.batch import Batch
from particlecli.render.bodies import Bodies
from particlecli.render.camera import View, views_of
from particlecli.render.colour import from_hex
from particlecli.render.develop import WORDS, develop, expose
from particlecli.render.ground import GroundPlane, coverage, facing_planes, planes_of, sizes
from particlecli.render.looks import LOOKS
from particlecli.render.painter import Painter
from particlecli.render.particles import room_of
from particlecli.render.pyramid import pyramids_of
from particlecli.render.shadows import CELLS, Shadows, casters
from particlecli.render.shot import LINES
from particlecli.render.sprites import SEEN
from particlecli.render.tint import tint_of
from particlecli.render.tone import dither, encoding_table, fixed, sky_light
from particlecli.scene.look import GroupLook
from particlecli.scene.model import Scene
from particlecli.scene.planes import Plane

BLOOM = ((2, 0.15), (3, 0.2), (4, 0.25), (5, 0.25), (6, 0.15))
"""Shares of the scattered light by level of a picture of 720 lines: Gaussian-like, 4 to 60 pixels wide."""


class Renderer:
    """Renders the frames of one scene. Taichi must have been started (`runtime.start`)."""

    def __init__(self, scene: Scene, width: int | None = None, height: int | None = None) -> None:
        """A picture of the scene's resolution unless `width` and `height` say otherwise."""
        runtime.use(self)
        self.width = width or scene.camera.resolution[0]
        self.height = height or scene.camera.resolution[1]
        self._view_at = views_of(scene.camera, self.width, self.height, scene.frames)
        look = scene.look
        self._planes_at, self._ground = planes_of(scene), look.ground
        below = sizes(self.width, self.height) if self._planes_at(0.0) else []
        grid = [(CELLS, CELLS)] if casters(scene) else []
        self._pyramid, *rest = pyramids_of([(self.width, self.height), *below, *grid])
        self._below = rest[: len(below)]
        self._shadows = Shadows(scene, rest[-1]) if grid else None
        largest = min(self._pyramid.largest, float(self.height))
        self._painters, self._colors = _painters(scene, largest)
        self._bodies = Bodies.of(scene, (self.width, self.height), largest)
        self._aim(self._view_at(0.0), self._planes_at(0.0))
        self._soil = vec4(*(look.ground.brightness * look.exposure * from_hex(look.ground.color)), 0.0)
        self._bloom = look.bloom
        self._stays = _stays(self.height, len(self._pyramid.levels))
        self._exposure = look.exposure
        self._sky = vec4(*sky_light(look.background), 0.0)
        self._encoding = fixed(encoding_table(look.background))
        packs = -(-self.width // PACK)
        self._dither = fixed(dither(packs * PACK, self.height))
        self._counter = np.zeros(1, np.int32)
        self._image = np.zeros((self.height, packs * WORDS), np.int32)

    def _aim(self, view: View, standing: Sequence[Plane]) -> None:
        """Look from where the camera is at planes where they are."""
        self.view, self._standing = view, standing
        for painter in self._painters.values():
            painter.aim(view)
        planes = self._facing = facing_planes(standing, view, self._ground.haze)
        self._grounds = [GroundPlane(plane, self._ground, view, *self._below) for plane in planes]
        self._hiding = np.array([[*plane.normal, plane.height] for plane in planes] or [[0.0] * 4], np.float32)
        if self._bodies:
            self._bodies.aim(view, self._hiding, len(planes))
        self._cover = self._ground_cover = coverage(planes, view)
        self._sky_seen = 1.0 - self._ground_cover

    def needs(self, group: str) -> frozenset[str]:
        """Which of velocities, ages, lifetimes and temperatures frames must carry of a group."""
        painter = self._painters.get(group)
        if painter:
            return painter.needs
        return self._bodies.needs(group) if self._bodies else frozenset()

    def render(self, frame: Frame) -> NDArray[np.uint8]:
        """The picture of a frame.

        Returns:
            sRGB values, shape (height, width, 3); valid until the next call.
        """
        self._gather(frame)
        arena = self._pyramid.arena
        develop(
            arena.light, arena.rows, arena.places, self._counter, *self._geometry, self.width, self.height,
            self._kept, self._exposure, self._sky, self._soil, self._cover, self._sky_seen, self._encoding,
            self._dither, self._image, bool(self._grounds), self._dressed,
        )  # fmt: skip
        pixels: NDArray[np.uint8] = self._image.view(np.uint8).reshape(self.height, -1, 3)[:, : self.width]
        return np.ascontiguousarray(pixels)

    def light(self, frame: Frame) -> NDArray[np.float32]:
        """Light of a frame's particles before exposure and tone, linear sRGB, shape (height, width, 3)."""
        self._gather(frame)
        image: NDArray[np.float32] = np.empty((self.height, self.width, 3), np.float32)
        arena = self._pyramid.arena
        expose(
            arena.light, arena.rows, self._counter, *self._geometry, self.width, self.height, self._kept, image
        )  # fmt: skip
        return image

    @property
    def _geometry(self) -> tuple[int, int, int, int]:
        finest, coarse = self._pyramid.levels[:2]
        return finest.origin, finest.pitch, coarse.origin, coarse.pitch

    @property
    def _kept(self) -> float:
        return 1.0 - self._bloom * (1.0 - float(self._stays[0]))

    def _gather(self, frame: Frame) -> None:
        view, standing = self._view_at(frame.time), self._planes_at(frame.time)
        if view is not self.view or standing is not self._standing:
            self._aim(view, standing)
        pyramid = self._pyramid
        pyramid.arena.claim(self)
        pyramid.clear(1)  # developing the last picture has emptied level 0
        groups = [(painter, painter.particles(frame.groups[name])) for name, painter in self._painters.items()]
        for ground in self._grounds:
            ground.add(groups, self._colors, pyramid)
        self._lay(frame)
        layer = self._bodies.layer if self._bodies else None
        batch = Batch({SEEN: pyramid}, self._colors, room_of(particles for _, particles in groups))
        for painter, particles in groups:
            painter.draw(particles, batch, self._hiding, len(self._grounds), layer)
        batch.draw()
        pyramid.collapse(self._bloom, self._stays, onto=1)

    def _lay(self, frame: Frame) -> None:
        """Draw shadows, and lay bodies over what is behind them all."""
        if not self._dressed:
            return
        self._cover, self._sky_seen = self._ground_cover.copy(), 1.0 - self._ground_cover
        if self._shadows:
            self._shadows.fall(frame, self._facing, self.view, self._cover)
        if self._bodies:
            self._bodies.draw(frame, self._sky_seen, self._cover)
            self._bodies.layer.lay(self._pyramid, self._sky_seen, self._cover)

    @property
    def _dressed(self) -> bool:
        """Whether there are bodies or shadows, and so sky and ground change from frame to frame."""
        return self._bodies is not None or self._shadows is not None


def _painters(scene: Scene, largest: float) -> tuple[dict[str, Painter], NDArray[np.float32]]:
    """Painters of the groups that are light, and the tables of all their tints, one below the other."""
    painters, tables, places = {}, [np.zeros((1, 4), np.float32)], 1
    for place, name in enumerate(scene.groups):
        style = scene.look.groups.get(name, GroupLook())
        if style.as_ in LOOKS:
            tint = tint_of(style.color, place)
            painters[name] = Painter(style, LOOKS[style.as_], tint, places, 1 / scene.fps, largest)
            tables.append(tint.table)
            places += len(tint.table)
    return painters, np.concatenate(tables)


def _stays(height: int, levels: int) -> NDArray[np.float32]:
    """For each level, the part of the bloom that settles there, of what has come so far; shape (levels,)."""
    shift = math.log2(height / LINES)
    shares = np.zeros(levels)
    for level in range(levels):
        shares[level] = sum(share * max(0.0, 1.0 - abs(level - place - shift)) for place, share in BLOOM)
    rest = np.cumsum(shares[::-1])[::-1]
    return np.divide(shares, rest, out=np.ones(levels), where=rest > 0).astype(np.float32)

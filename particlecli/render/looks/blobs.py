"""Blobs: particles that merge into one lit body of liquid, the isosurface of their summed density."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import GroupFrame
from particlecli.render.camera import View
from particlecli.render.liquids.compose_kernels import compose
from particlecli.render.liquids.density import LOWEST
from particlecli.render.liquids.ellipsoids import put_blobs
from particlecli.render.liquids.lighting import OPAQUE, ROWS
from particlecli.render.liquids.material import table_of
from particlecli.render.liquids.records import NUMBERS, POWER
from particlecli.render.liquids.room import Room, room_for
from particlecli.render.liquids.surface_kernels import draw_surface
from particlecli.render.looks.body import Subject
from particlecli.render.particles import Particles
from particlecli.render.shot import lens_row, paint_of
from particlecli.render.solids.layer import Layer
from particlecli.render.tasks import CHUNK
from particlecli.scene.look import Liquid

Floats = NDArray[np.float32]

BENDING = 0.04
"""How far what is behind a clear surface shifts at most, heights of the picture."""

CLEAREST = 0.98
"""More opaque liquids let nothing through, however thin they are."""


class Blobs:
    """The liquid of one group.

    Attributes:
        subject: the group.
    """

    def __init__(self, subject: Subject, size: tuple[int, int]) -> None:
        self.subject = subject
        self._liquid = subject.style.liquid or Liquid()
        self._width, self._height = size
        self._colors = subject.colors
        opacity = subject.style.opacity
        self._opacity_depth = -math.log(1.0 - opacity) if opacity < CLEAREST else OPAQUE
        self._bending = 0.0 if opacity >= CLEAREST else BENDING * self._height
        reach = 1.0 + self._liquid.merge
        self._reach, self._level = reach, 1.0 - reach**-2
        self._lowest = self._level * LOWEST ** (1 / POWER)
        self._rows, self._keys = np.zeros((1, NUMBERS), np.float32), np.zeros(1, np.uint16)
        self._order, self._others = np.empty(1, np.int32), np.empty(1, np.int32)
        self._counter = np.zeros(1, np.int32)

    @property
    def needs(self) -> frozenset[str]:
        """Fields of a frame that the look is computed from."""
        fading = frozenset({"ages", "lifetimes"}) if self.subject.fades else frozenset()
        moving = frozenset({"velocities"}) if self._liquid.stretch > 0 else frozenset()
        return self.subject.tint.needs | fading | moving

    def aim(self, view: View) -> None:
        """Take a camera's view."""
        style = self.subject.style.model_copy(update={"brightness": 1.0})
        paint = paint_of(style, self.subject.tint, view)
        self._view = view
        self._shots = [
            np.concatenate([lens_row(view, at, self.subject.largest), paint]) for at in (view.position, np.zeros(3))
        ]
        self._table = table_of(view, self.subject.light, self._liquid)
        self._rays = view.rays().astype(np.float32)

    def draw(self, group: GroupFrame, layer: Layer, planes: Floats, hiding: int, sky: Floats, cover: Floats) -> None:
        """Lay the surface of a group's particles into a layer of bodies.

        Args:
            group: one group of a frame.
            layer: has been drawn.
            planes, hiding: (normal, height of the camera), of which the first `hiding` hide what is below them.
            sky, cover: shape (height, width or more), how much is seen of sky and ground behind all bodies.
        """
        if not len(group):
            return
        room = room_for(self._width, self._height)
        self._put(group, planes, hiding)
        self._find(len(group), room)
        compose(
            room.lit, room.shape, room.held, room.opened, layer.fields.color, layer.fields.depth, sky, cover,
            self._width, self._height, self._bending, planes, hiding, self._rays,
        )  # fmt: skip

    def _put(self, group: GroupFrame, planes: Floats, hiding: int) -> None:
        tint, stretch = self.subject.tint, self._liquid.stretch
        particles = Particles.of(group, tint, self._view.position, moving=stretch > 0)
        if len(self._rows) < particles.count:
            self._rows = np.zeros((particles.count, NUMBERS), np.float32)
            self._keys = np.zeros(particles.count, np.uint16)
        put_blobs(
            particles.count, *particles.arrays, self._shots[particles.relative], planes, hiding, self._colors,
            self._rows, self._keys, particles.source(tint),
            self.subject.fades and particles.has_lifetimes, self._reach, stretch,
        )  # fmt: skip

    def _find(self, count: int, room: Room) -> None:
        chunks, bands = -(-count // CHUNK), -(-self._height // ROWS)
        counts = np.zeros((chunks + 1) * bands + 1, np.int32)
        ranked = np.argsort(self._keys[:count], kind="stable")
        self._surface(ranked, counts, room)
        if counts[-1] > len(self._order):
            self._order, self._others = (np.empty(int(1.25 * counts[-1]), np.int32) for _ in range(2))
            self._surface(ranked, counts, room)

    def _surface(self, ranked: NDArray[np.int64], counts: NDArray[np.int32], room: Room) -> None:
        draw_surface(
            len(ranked), ranked, self._rows, counts, self._order, self._others, room.cells, room.farthest, room.visits,
            room.limits, room.thick, self._width, self._height, self._level, self._lowest, self._opacity_depth,
            self._liquid.metal, self._table, self._shots[1], room.lit, room.shape, self._counter,
        )  # fmt: skip

"""The layer that the bodies of a picture are drawn into, before it is laid over the light."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli import runtime
from particlecli.render.camera import View
from particlecli.render.particles import Particles
from particlecli.render.pyramid import Pyramid
from particlecli.render.shot import NEAREST
from particlecli.render.solids.layer_kernels import draw_bodies
from particlecli.render.solids.laying_kernels import hide, lay
from particlecli.render.solids.records import HEAD, Records
from particlecli.render.solids.sorting import DIGITS
from particlecli.render.solids.tiles import KEPT, PACK, TILE, TILE_PACKS
from particlecli.render.sprites import Store
from particlecli.render.tasks import CHUNK, WORKERS

Floats = NDArray[np.float32]

_FEWEST = 1 << 16


class Fields:
    """Room for a layer.

    Attributes:
        color: shape (pixels,) of 4: light of bodies, and the share of what is behind them that is seen.
        depth: shape (pixels,), of what hides half of what is behind it, m.
        store: shape (workers · TILE_PACKS, KEPT) of PACK, the same of the tiles at which workers are.
        still_open: shape (workers, TILE), a bit for each pixel of such a tile: what is behind it can be seen.
    """

    def __init__(self, pixels: int) -> None:
        self.color, self.depth = ti.field(ti.types.vector(4, ti.f32)), ti.field(ti.f32)
        self.store = ti.field(ti.types.vector(PACK, ti.f32))
        self.still_open = ti.field(ti.u32)
        builder = ti.FieldsBuilder()
        for field in (self.color, self.depth):
            builder.dense(ti.i, pixels).place(field)
        builder.dense(ti.ij, (WORKERS * TILE_PACKS, KEPT)).place(self.store)
        builder.dense(ti.ij, (WORKERS, TILE)).place(self.still_open)
        builder.finalize()


@cache
def _fields(epoch: int, pixels: int) -> Fields:  # noqa: ARG001 - a restart frees all fields
    return Fields(pixels)


class Layer:
    """The bodies of one picture.

    Args:
        width, height: of the picture.
        looks: shape (looks, 5), see `layer_kernels.draw_bodies`.
        sheets: texels of all sheets, shape (texels, 4).
        kinds: which kinds of bodies there are.
        numbers: in a row of a body.

    Attributes:
        bodies: what is drawn.
        looks: as given.
    """

    def __init__(
        self, width: int, height: int, looks: Floats, sheets: Floats, kinds: Sequence[int], numbers: int
    ) -> None:  # fmt: skip
        self.bodies = Records(numbers)
        self.looks = looks
        self.fields = _fields(runtime.epoch(), max(_FEWEST, 1 << (width * height - 1).bit_length()))
        self._width, self._height, self._sheets, self._kinds = width, height, sheets, tuple(kinds)
        self._digits = np.empty((WORKERS, 2 * DIGITS), np.int32)
        self._counter = np.zeros(1, np.int32)
        self._make_room(1)

    def aim(self, view: View, caps: Floats) -> None:
        """Take a camera's view and the caps for it, shape (texels, 8); before `draw`."""
        self._near, self._caps = NEAREST * view.distance, caps

    def draw(self) -> None:
        """Draw the bodies that there are; what was drawn before is gone."""
        count = self.bodies.count
        tiles = -(-self._width // TILE) * -(-self._height // TILE)
        counts = np.empty((-(-count // CHUNK) + 1) * tiles + 1, np.int32)
        if len(self._keys) < count:
            self._make_room(count)
        self._draw(counts)
        if counts[-1] > len(self._keys):
            self._make_room(int(1.25 * counts[-1]))
            self._draw(counts)

    def _draw(self, counts: NDArray[np.int32]) -> None:
        fields, bodies = self.fields, self.bodies
        draw_bodies(
            bodies.count, bodies.heads, bodies.rows, counts, self._heads, self._keys, self._order, self._digits,
            self._width, self._height, self._near, fields.color, fields.depth, fields.store, fields.still_open,
            self.looks, self._caps, self._sheets, self._counter, self._kinds,
        )  # fmt: skip

    def _make_room(self, count: int) -> None:
        self._heads = np.empty((count, HEAD), np.float32)
        self._keys, self._order = np.empty(count, np.int32), np.empty((2, count), np.int32)

    def lay(self, pyramid: Pyramid, sky: Floats, cover: Floats) -> None:
        """Lay the bodies over a picture's light, and over how much of sky and ground is seen of each pixel."""
        finest = pyramid.levels[0]
        lay(
            self.fields.color, pyramid.arena.light, finest.origin, finest.pitch, self._width,
            self._height, sky, cover,
        )  # fmt: skip

    def hide(self, store: Store, place: int, first: int, count: int, particles: Particles, view: View) -> None:
        """Dim `count` sprites from a place on, of the particles from the `first` on, where bodies are before them."""
        origin = np.zeros(3) if particles.relative else view.position
        hide(
            first, count, particles.positions, *origin.tolist(), *view.forward.tolist(), self._width, self._height,
            self.fields.color, self.fields.depth, store.sprites, place,
        )  # fmt: skip

"""Sprites: light spread over round spots of the picture, as packs of numbers that kernels fill and rasters draw.

Like the light of pictures they are kept in fields, see `arena`. As kernels are compiled for the fields they use, there
is one store for groups of few particles and one for groups of many, and all renderers share them.
"""

from __future__ import annotations

from functools import cache

import taichi as ti

from particlecli import runtime
from particlecli.render.tasks import CHUNK

X, Y, RADIUS, ENERGY, TINT, TAIL_X, TAIL_Y = range(7)
"""Numbers of a sprite: the middle and the radius, pixels; the energy, which is the sum of the pixel values that it
adds, for a tint of 1, and 0 where there is nothing to draw; the place in the table of colours; and for smeared sprites
the way back from the middle to where it was when the shutter opened, pixels."""

SEEN, POOLED = range(2)
"""The sets of sprites in a store: those of a picture or a mirror, and those of light that falls on a plane."""

PACK = 16
"""Sprites that are taken at once where the work is the same for all."""

FEW, MANY = 1 << 17, 1 << 20
"""Sprites that a set has room for; no more are drawn at once."""

_LEAST_RECORDS = 1 << 19
_BINS = 1 << 11


class Store:
    """Room for sprites and for the records that rasters sort them into.

    Attributes:
        sprites: shape (2, 7, packs) of PACK; set, number, pack.
        records: shape (room,) of 4.
        counts: shape (places,); see `binning`.
    """

    def __init__(self, count: int) -> None:
        self.room = max(count, _LEAST_RECORDS)
        self._places = (count // CHUNK + 1) * _BINS
        self.sprites = ti.field(ti.types.vector(PACK, ti.f32))
        self.records = ti.field(ti.types.vector(4, ti.f32))
        self.counts = ti.field(ti.i32)
        builder = ti.FieldsBuilder()
        builder.dense(ti.ijk, (2, TAIL_Y + 1, count // PACK)).place(self.sprites)
        builder.dense(ti.i, self.room).place(self.records)
        builder.dense(ti.i, self._places).place(self.counts)
        builder.finalize()

    def most(self, bins: int) -> int:
        """How many sprites can be sorted into so many bins at once."""
        return (self._places // (bins + 1) - 1) * CHUNK


class Sprites:
    """One set of sprites.

    Attributes:
        which: its place in stores.
        store: where they are now.
    """

    def __init__(self, which: int) -> None:
        self.which = which
        self.store = store_for(0)

    def reserve(self, count: int) -> None:
        """Make room for so many sprites, MANY at most; what was there is lost."""
        self.store = store_for(count)


def store_for(count: int) -> Store:
    """The store with room for so many sprites."""
    return _store(runtime.epoch(), FEW if count <= FEW else MANY)


@cache
def _store(epoch: int, count: int) -> Store:  # noqa: ARG001 - a restart frees all fields
    return Store(count)

"""Sprites: light spread over round spots of the picture, as packs of numbers that kernels fill and rasters draw.

Like the light of pictures they are kept in fields, see `arena`. As kernels are compiled for the fields they use, there
is one store for groups of few particles and one for groups of many, and all renderers share them.
"""

from __future__ import annotations

from dataclasses import dataclass
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


@dataclass(frozen=True)
class Span:
    """Sprites of one group, next to each other in a set.

    Attributes:
        first, end: the first, at a multiple of PACK, and the one behind the last.
        colors: where the group's tint begins in the table of all colours.
        halo: share of the light that forms a halo around each sprite.
        smeared: whether they have tails.
        crisp: whether they are drawn as discs with sharp edges rather than as soft light.
    """

    first: int
    end: int
    colors: int
    halo: float
    smeared: bool = False
    crisp: bool = False


class Store:
    """Room for sprites and for the records that rasters sort them into.

    Attributes:
        size: how many sprites each set has room for.
        sprites: shape (2, 7, packs) of PACK; set, number, pack.
        room, records: how many records there is room for, and shape (room,) of 4.
        counts: shape (places,); see `binning`.
    """

    def __init__(self, count: int) -> None:
        self.size = count
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

    def most_chunks(self, bins: int) -> int:
        """How many chunks of sprites can be sorted into so many bins at once."""
        return self._places // (bins + 1) - 1


def store_for(count: int) -> Store:
    """The store with room for so many sprites."""
    return _store(runtime.epoch(), FEW if count <= FEW else MANY)


@cache
def _store(epoch: int, count: int) -> Store:  # noqa: ARG001 - a restart frees all fields
    return Store(count)

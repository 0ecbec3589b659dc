"""Where isosurfaces are kept while they are found."""

from __future__ import annotations

from functools import cache

import taichi as ti

from particlecli import runtime
from particlecli.render.liquids.density import CELLS, PACK
from particlecli.render.liquids.lighting import COARSE, LINES, ROWS
from particlecli.render.tasks import WORKERS


class Room:
    """Room for a surface.

    Attributes:
        cells: shape (workers, packs, CELLS) of PACK; see `density`.
        farthest, visits: shape (workers, packs): depth up to where a pack looks for blobs, and how often it has.
        limits: shape (workers, packs of a line): the farthest of those depths of the packs above each other.
        thick: shape (workers, squares): how many blobs rays go through.
        lit: shape (pixels,) of 4: light, and how much of what is behind is hidden, where all is covered.
        shape: shape (pixels,) of 4: how much is covered; how far the surface is turned to the right and down, 0 to 1;
            and depth, m.
        held, opened: shape (pixels,) of 4 and 3: what lies behind; colour; how much is seen of sky and of ground, and
            depth, m.
    """

    def __init__(self, pixels: int, packs: int) -> None:
        self.cells = ti.field(ti.types.vector(PACK, ti.f32))
        self.farthest, self.limits, self.thick = ti.field(ti.f32), ti.field(ti.f32), ti.field(ti.f32)
        self.visits = ti.field(ti.i32)
        self.lit, self.shape, self.held = (ti.field(ti.types.vector(4, ti.f32)) for _ in range(3))
        self.opened = ti.field(ti.types.vector(3, ti.f32))
        builder = ti.FieldsBuilder()
        builder.dense(ti.ijk, (WORKERS, packs, CELLS)).place(self.cells)
        for each in (self.farthest, self.visits, self.limits):
            builder.dense(ti.ij, (WORKERS, packs)).place(each)
        builder.dense(ti.ij, (WORKERS, packs * LINES * PACK // COARSE)).place(self.thick)
        for each in (self.lit, self.shape, self.held, self.opened):
            builder.dense(ti.i, pixels).place(each)
        builder.finalize()


@cache
def _room(epoch: int, pixels: int, packs: int) -> Room:  # noqa: ARG001 - a restart frees all fields
    return Room(pixels, packs)


def room_for(width: int, height: int) -> Room:
    """Room for a picture."""
    packs = -(-width // PACK) * ROWS
    sizes = (max(1 << 16, 1 << (width * height - 1).bit_length()), max(1 << 9, 1 << (packs - 1).bit_length()))
    return _room(runtime.epoch(), *sizes)

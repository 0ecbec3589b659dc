"""Where the light of pictures is kept while they are made.

Kernels work on fields here, not on NumPy arrays: of a field Taichi tells the compiler that the components of a node
lie next to each other, so they become one register; of an array it does not. As kernels are compiled for the fields
they use, an arena has one of few sizes and is shared by all pictures that it has room for, one after the other.
"""

from functools import cache

import taichi as ti

from particlecli import runtime
from particlecli.render.tasks import WORKERS

PACK = 16
"""Pixels that are toned at once."""

_FEWEST = 1 << 19, 1 << 16, 1 << 9


class Arena:
    """Room for light.

    Attributes:
        light: shape (nodes,) of 4; red, green, blue, and the luminance of the part that has a halo.
        halo, bloom: shape (coarse nodes,) of 4; what came from finer levels.
        rows: shape (workers, columns) of 4; a row of a picture on which a worker is at work.
        places: shape (workers, 3, columns / PACK) of PACK; likewise, places in the table of its values.
    """

    def __init__(self, nodes: int, coarse: int, columns: int) -> None:
        light = ti.types.vector(4, ti.f32)
        self.light, self.halo, self.bloom, self.rows = (ti.field(light) for _ in range(4))
        self.places = ti.field(ti.types.vector(PACK, ti.i32))
        builder = ti.FieldsBuilder()
        builder.dense(ti.i, nodes).place(self.light)
        builder.dense(ti.i, coarse).place(self.halo)
        builder.dense(ti.i, coarse).place(self.bloom)
        builder.dense(ti.ij, (WORKERS, columns)).place(self.rows)
        builder.dense(ti.ijk, (WORKERS, 3, columns // PACK)).place(self.places)
        builder.finalize()
        self._owner: object = None

    def claim(self, owner: object) -> None:
        """Empty the arena, unless it is new or it was the same owner who used it last."""
        if self._owner is not None and self._owner is not owner:
            for field in (self.light, self.halo, self.bloom):
                field.fill(0.0)
        self._owner = owner


def arena_for(nodes: int, coarse: int, columns: int) -> Arena:
    """An arena with room for so many nodes of light, nodes of halos, and columns of a picture."""
    asked = (nodes, coarse, columns)
    sizes = (max(fewest, 1 << (size - 1).bit_length()) for fewest, size in zip(_FEWEST, asked, strict=True))
    return _arena(runtime.epoch(), *sizes)


@cache
def _arena(epoch: int, nodes: int, coarse: int, columns: int) -> Arena:  # noqa: ARG001 - a restart frees all fields
    return Arena(nodes, coarse, columns)

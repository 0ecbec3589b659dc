"""Kernels of the neighbour search: sorting rows into the bins of a grid, and listing what is within reach of packs.

The grid's bins form columns; along the columns, which run to and fro as a snake does, bins are thin. Rows sorted by
bin therefore fill packs with particles that are close together in every direction, whatever pack one looks at, and
the candidates near a pack form few long runs of rows. Sorting keeps the order within a bin, so nothing depends on the
number of threads. Bins at the border of the grid hold all that lies beyond.
"""

from dataclasses import dataclass

import numpy as np
import taichi as ti
from numpy.typing import NDArray

INTEGERS = ti.types.ndarray(dtype=ti.i32, ndim=1)
VECTOR3 = ti.types.vector(3, ti.f64)
INDEX3 = ti.types.vector(3, ti.i32)


@dataclass(frozen=True)
class Grid:
    """A box cut into bins.

    Attributes:
        low: its lower corner, m, axes in the order of `axes`.
        sides: of a bin along each of them, m.
        counts: bins along each of them.
        axes: the axes x, y, z (0, 1, 2) in the order in which bins are numbered; along the last they are thin.
    """

    low: NDArray[np.float64]
    sides: NDArray[np.float64]
    counts: NDArray[np.int32]
    axes: NDArray[np.int32]

    @property
    def bins(self) -> int:
        """How many bins there are."""
        return int(np.prod(self.counts))

    @property
    def arguments(self):
        """The grid as kernels take it."""
        return ti.Vector(self.low), ti.Vector(self.sides), ti.Vector(self.counts), ti.Vector(self.axes)


@ti.func
def place(value, low, inverse, count):
    """The bin along an axis of a coordinate; grows with it, whatever rounding does."""
    bin_ = ti.cast(ti.floor(ti.min(ti.max((value - low) * inverse, -1.0), 2.0e9)), ti.i32)
    return ti.min(ti.max(bin_, 0), count - 1)


@ti.func
def number(a, b, c, counts):
    """The number of a bin along the snake."""
    along = ti.select(a & 1 == 0, b, counts[1] - 1 - b)
    column = a * counts[1] + along
    return column * counts[2] + ti.select(column & 1 == 0, c, counts[2] - 1 - c)


@ti.func
def bin_of(position, low, sides, counts, axes):
    """The number of the bin of a position (at least three components)."""
    inverse = 1.0 / sides
    p = [place(ti.cast(picked(position, axes[k]), ti.f64), low[k], inverse[k], counts[k]) for k in ti.static(range(3))]
    return number(p[0], p[1], p[2], counts)


@ti.func
def picked(position, axis):
    """A component known only when the kernel runs."""
    return ti.select(axis == 0, position[0], ti.select(axis == 1, position[1], position[2]))


@ti.kernel
def sort(keys: INTEGERS, starts: INTEGERS, order: INTEGERS):
    """Counting sort that keeps the order of equal keys; items with key −1 are left out.

    Args:
        keys: bin of each item.
        starts: filled: first place of each bin; one longer than there are bins.
        order: filled: items in the order of their bins.
    """
    ti.loop_config(serialize=True)
    for _ in range(1):
        for k in range(starts.shape[0]):
            starts[k] = 0
        for i in range(keys.shape[0]):
            if keys[i] >= 0:
                starts[keys[i]] = starts[keys[i]] + 1
        total = 0
        for k in range(starts.shape[0]):
            total = total + starts[k]
            starts[k] = total
        # From behind, each bin's end moves down to its beginning.
        for n in range(keys.shape[0]):
            i = keys.shape[0] - 1 - n
            if keys[i] >= 0:
                starts[keys[i]] = starts[keys[i]] - 1
                order[starts[keys[i]]] = i


@ti.kernel
def bins_of(
    positions: ti.types.ndarray(dtype=ti.f64, ndim=2),
    acts: INTEGERS,
    low: VECTOR3,
    sides: VECTOR3,
    counts: INDEX3,
    axes: INDEX3,
    keys: INTEGERS,
):
    """The bin of each position, −1 for those that do not act."""
    for i in range(keys.shape[0]):
        position = ti.Vector([positions[0, i], positions[1, i], positions[2, i]])
        keys[i] = bin_of(position, low, sides, counts, axes) if acts[i] != 0 else -1

"""The particles of one group, component by component, in packs of 16 lanes."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli.dynamics.deaths import CAUSES
from particlecli.dynamics.group_plan import INTEGER_COMPONENTS, LANES
from particlecli.dynamics.state_kernels import compress, copy_in, copy_out, overwrite_row

FEW = 1 << 14
"""Where there is room for no more particles, one thread copies them sooner than others would wake up."""


class PackedState:
    """Packed arrays with room for a fixed number of particles; the living ones come first, in order of birth.

    Attributes:
        reals: field of packs, shape (real components, packs).
        integers: field of packs of 32-bit integers, shape (integer components, packs).
        count: how many particles there are now.
        capacity: how many there is room for.
    """

    def __init__(self, components: tuple[str, ...], capacity: int, real) -> None:
        self.real_dtype = np.float64 if real == ti.f64 else np.float32
        self.capacity = capacity
        self.count = 0
        self._integer_names = tuple(name for name in components if name in INTEGER_COMPONENTS)
        self._real_names = tuple(name for name in components if name not in INTEGER_COMPONENTS)
        self._rows = {name: row for names in (self._integer_names, self._real_names) for row, name in enumerate(names)}
        self._no_integers = np.zeros((0, 0), np.int32)
        self._no_reals = np.zeros((0, 0), self.real_dtype)
        self.reals = ti.field(ti.types.vector(LANES, real))
        self.integers = ti.field(ti.types.vector(LANES, ti.i32))
        packs = max(1, -(-capacity // LANES))
        builder = ti.FieldsBuilder()
        builder.dense(ti.ij, (len(self._real_names), packs)).place(self.reals)
        builder.dense(ti.ij, (max(1, len(self._integer_names)), packs if self._integer_names else 1)).place(
            self.integers
        )
        self._tree = builder.finalize()

    @property
    def packs(self) -> int:
        """Packs that hold the living particles; the last one may have idle lanes."""
        return -(-self.count // LANES)

    def row(self, name: str) -> int:
        """Where a component is kept: the first index into `reals` or `integers`."""
        return self._rows[name]

    def append(self, columns: Mapping[str, np.ndarray]) -> None:
        """Add particles behind the living ones; one array of equal length for each component."""
        reals = np.array([columns[name] for name in self._real_names], self.real_dtype)
        integers = self._no_integers
        if self._integer_names:
            integers = np.array([columns[name] for name in self._integer_names], np.int32)
        copy_in(self.reals, self.integers, self.count, reals, integers, self.capacity <= FEW)
        self.count += reals.shape[1]

    def read(self, names: tuple[str, ...]) -> NDArray[Any]:
        """Components of the living particles, shape (len(names), count); all real or all integer."""
        if names[0] in INTEGER_COMPONENTS:
            return self.read_both((), names)[1]
        return self.read_both(names, ())[0]

    def read_both(
        self, reals: tuple[str, ...], integers: tuple[str, ...]
    ) -> tuple[NDArray[np.floating[Any]], NDArray[np.int32]]:
        """Real and integer components of the living particles, shapes (names, count), with one launch of a kernel."""
        real_rows, integer_rows = [self._rows[name] for name in reals], [self._rows[name] for name in integers]
        real_values = np.empty((len(reals), self.count), self.real_dtype) if reals else self._no_reals
        integer_values = np.empty((len(integers), self.count), np.int32) if integers else self._no_integers
        if self.count:
            copy_out(
                self.reals, self.integers, self.count, _bits(real_rows), _bits(integer_rows),
                real_values, integer_values, self.capacity <= FEW,
            )  # fmt: skip
        return _in_order(real_values, real_rows), _in_order(integer_values, integer_rows)

    def overwrite(self, names: tuple[str, ...], values: np.ndarray) -> None:
        """Replace real components of all living particles; shape (len(names), count)."""
        for name, row in zip(names, values, strict=True):
            overwrite_row(self.reals, self._rows[name], np.ascontiguousarray(row, dtype=self.real_dtype))

    def bury(self) -> dict[str, int]:
        """Remove the dead, the others closing up in order; returns how many died by each cause."""
        tally = np.zeros(len(CAUSES) + 1, dtype=np.int32)
        rows = len(self._real_names), len(self._integer_names)
        compress(self.reals, self.integers, *rows, self._rows["fate"], self.count, tally)
        self.count = int(tally[0])
        return {cause: int(number) for cause, number in zip(CAUSES, tally[1:], strict=True) if number}


def _bits(rows: list[int]) -> int:
    return sum(1 << row for row in rows)


def _in_order(values: NDArray[Any], rows: list[int]) -> NDArray[Any]:
    """Values that a kernel copied in ascending order of rows, in the order asked for."""
    ascending = sorted(rows)
    return values if rows == ascending else values[[ascending.index(row) for row in rows]]

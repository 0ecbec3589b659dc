"""The particles of one group, component by component, in packs of 16 lanes."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli.dynamics.deaths import CAUSES
from particlecli.dynamics.group_plan import INTEGER_COMPONENTS, LANES
from particlecli.dynamics.memory import FieldMemory


class PackedState:
    """Packed arrays with room for a fixed number of particles; the living ones come first, in order of birth.

    Args:
        components: what is kept of each particle.
        capacity: how many particles there is room for.
        real: type of the components that are no integers, ti.f32 or ti.f64.
        memory: of the system.

    Attributes:
        reals: field of packs, shape (real components, packs).
        integers: field of packs of 32-bit integers, shape (integer components, packs).
        count: how many particles there are now.
        capacity: how many there is room for.
    """

    def __init__(self, components: tuple[str, ...], capacity: int, real: Any, memory: FieldMemory) -> None:
        self.real_dtype = np.float64 if real == ti.f64 else np.float32
        self.capacity = capacity
        self.count = 0
        self._integer_names = tuple(name for name in components if name in INTEGER_COMPONENTS)
        self._real_names = tuple(name for name in components if name not in INTEGER_COMPONENTS)
        self._rows = {name: row for names in (self._integer_names, self._real_names) for row, name in enumerate(names)}
        self.reals = ti.field(ti.types.vector(LANES, real))
        self.integers = ti.field(ti.types.vector(LANES, ti.i32))
        packs = max(1, -(-capacity // LANES))
        builder = ti.FieldsBuilder()
        builder.dense(ti.ij, (len(self._real_names), packs)).place(self.reals)
        builder.dense(ti.ij, (max(1, len(self._integer_names)), packs if self._integer_names else 1)).place(
            self.integers
        )
        self._tree = builder.finalize()
        self._views = memory.view(self.reals), memory.view(self.integers)

    @property
    def packs(self) -> int:
        """Packs that hold the living particles; the last one may have idle lanes."""
        return -(-self.count // LANES)

    def row(self, name: str) -> int:
        """Where a component is kept: the first index into `reals` or `integers`."""
        return self._rows[name]

    def append(self, columns: Mapping[str, np.ndarray]) -> None:
        """Add particles behind the living ones; one array of equal length for each component."""
        count = len(columns[self._real_names[0]])
        for names, rows in zip((self._real_names, self._integer_names), self._all_rows(), strict=True):
            for name, row in zip(names, rows, strict=False):
                row[self.count : self.count + count] = columns[name]
        self.count += count

    def read(self, names: tuple[str, ...]) -> NDArray[Any]:
        """Components of the living particles, a copy, shape (len(names), count); all real or all integer."""
        rows = self._all_rows()[names[0] in INTEGER_COMPONENTS]
        return rows[[self._rows[name] for name in names], : self.count]

    def overwrite(self, names: tuple[str, ...], values: np.ndarray) -> None:
        """Replace real components of all living particles; shape (len(names), count)."""
        self._all_rows()[0][[self._rows[name] for name in names], : self.count] = values

    def bury(self) -> dict[str, int]:
        """Remove the dead, the others closing up in order; returns how many died by each cause."""
        reals, integers = self._all_rows()
        fates = integers[self._rows["fate"], : self.count]
        tally = np.bincount(np.maximum(fates, 0), minlength=len(CAUSES) + 1)
        kept = np.flatnonzero(fates <= 0)
        first = int(np.argmax(fates > 0))
        moved = kept[np.searchsorted(kept, first) :]
        for row in (*reals, *integers[: len(self._integer_names)]):
            row[first : len(kept)] = row[moved]
        self.count = len(kept)
        return {cause: int(number) for cause, number in zip(CAUSES, tally[1:], strict=True) if number}

    def _all_rows(self) -> tuple[NDArray[Any], NDArray[np.int32]]:
        """The memory of real and of integer components, row by row, shapes (components, 16 packs)."""
        reals, integers = (view.array for view in self._views)
        return reals.reshape(len(reals), -1), integers.reshape(len(integers), -1)

"""Rows of a sparse matrix in packs of 16, as kernels go through them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from particlecli.dynamics.group_plan import LANES


@dataclass(frozen=True)
class PackedRows:
    """The entries of each row, a slot for a pack of rows, filled up with zeros where a row has fewer than others.

    Attributes:
        starts: of each pack its first slot, and the end of the last; shape (packs + 1).
        columns: shape (slots, 16).
        values: shape (slots, 16).
    """

    starts: NDArray[np.int32]
    columns: NDArray[np.int32]
    values: NDArray[np.float64]

    @classmethod
    def of(cls, matrix: csr_array, first: int, blank: float = 0.0) -> PackedRows:
        """The rows of a matrix whose columns are numbered from `first`; entries that are not there are `blank`."""
        rows = -(-matrix.shape[0] // LANES)
        lengths = np.zeros(rows * LANES, np.int64)
        lengths[: matrix.shape[0]] = np.diff(matrix.indptr)
        starts = np.concatenate(([0], np.cumsum(lengths.reshape(-1, LANES).max(axis=1))))
        columns = np.full((starts[-1], LANES), first, np.int32)
        values = np.full((starts[-1], LANES), blank)
        owners = np.repeat(np.arange(len(lengths)), lengths)
        slots = starts[owners // LANES] + np.arange(matrix.nnz) - matrix.indptr[owners]
        columns[slots, owners % LANES] = matrix.indices + first
        values[slots, owners % LANES] = matrix.data
        return cls(starts.astype(np.int32), columns, values)

    @classmethod
    def joined(cls, parts: list[PackedRows]) -> PackedRows:
        """Some after the others."""
        slots = np.cumsum([0, *(part.starts[-1] for part in parts)])
        starts = [part.starts[:-1] + slot for part, slot in zip(parts, slots, strict=False)]
        return cls(
            np.concatenate([*starts, slots[-1:]]).astype(np.int32),
            np.concatenate([part.columns for part in parts]),
            np.concatenate([part.values for part in parts]),
        )

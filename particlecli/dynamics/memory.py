"""The memory of fields as NumPy arrays, so that the host fills and reads them without a kernel for each."""

import ctypes
from typing import Any

import numpy as np
import taichi as ti
from numpy.typing import NDArray
from taichi.lang.util import to_numpy_type

from particlecli.runtime import epoch


class FieldMemory:
    """The memory of some fields.

    Taichi fills and reads a field with a kernel that it compiles for that field alone, which takes most of a tenth of
    a second; the addresses of many fields together take one such kernel. What is placed in a field is there once the
    memory is open.
    """

    def __init__(self) -> None:
        self._waiting: list[FieldView] = []

    def view(self, field, values: NDArray[Any] | None = None) -> "FieldView":
        """The memory of a field, to be filled with values of its shape, a pack's lanes along the last axis."""
        found = FieldView(self, field, values)
        self._waiting.append(found)
        return found

    def table(self, real, values: NDArray[Any]):
        """A field of numbers, filled with these."""
        field = ti.field(real, shape=np.shape(values))
        self.view(field, values)
        return field

    def open(self) -> None:
        """Find out where the fields are, and fill them."""
        waiting, self._waiting = self._waiting, []
        if waiting:
            ti.sync()  # which lays out fields that are new
            for view, address in zip(waiting, _addresses([view.field for view in waiting]), strict=True):
                view.found(address)


class FieldView:
    """The memory of a field.

    Attributes:
        field: on the CPU; of numbers, vectors or matrices.
    """

    def __init__(self, memory: FieldMemory, field, values: NDArray[Any] | None) -> None:
        self.field = field
        self._memory = memory
        self._values = values
        self._array: NDArray[Any] | None = None
        self._epoch = epoch()

    @property
    def array(self) -> NDArray[Any]:
        """The field's numbers themselves, shape (*field, *vector or matrix): what is written there is in the field.

        Raises:
            RuntimeError: the field is gone, since Taichi was started anew.
        """
        if self._epoch != epoch():
            raise RuntimeError("the field is gone: Taichi was started anew")
        if self._array is None:
            self._memory.open()
        assert self._array is not None
        return self._array

    def found(self, address: int) -> None:
        """Take note of where the field is, and fill it."""
        dtype = np.dtype(to_numpy_type(self.field.dtype))
        cells = int(np.prod(self.field.shape))
        shape = (*self.field.shape, *_element(self.field))
        size = int(np.prod(shape)) * dtype.itemsize
        if self.field.parent()._cell_size_bytes * cells != size:
            raise ValueError("the components of a field must stand side by side")
        self._array = np.frombuffer((ctypes.c_byte * size).from_address(address), dtype).reshape(shape)
        if self._values is not None:
            self._array[...] = self._values
            self._values = None


def _element(field) -> tuple[int, ...]:
    """The shape of what stands at each place of a field."""
    if isinstance(field, ti.ScalarField):
        return ()
    return (field.n, field.m)[: field.ndim]


def _addresses(fields) -> list[int]:
    """Where the first number of each field is: how far from one field of its tree, of which the kernel tells."""
    trees = {each.parent()._snode_tree_id: each for each in fields}
    found = np.zeros(len(trees), np.uint64)
    _finder([each if isinstance(each, ti.ScalarField) else each.get_scalar_field(0) for each in trees.values()])(found)
    starts = {tree: int(address) - _offset(trees[tree]) for tree, address in zip(trees, found, strict=True)}
    return [starts[each.parent()._snode_tree_id] + _offset(each) for each in fields]


def _offset(field) -> int:
    """Where a field stands among the fields of its tree, bytes."""
    return field.parent()._offset_bytes_in_parent_cell


def _finder(fields):
    """A kernel that tells where fields of numbers begin."""
    origins = [(0,) * len(each.shape) for each in fields]

    @ti.kernel
    def find(found: ti.types.ndarray(dtype=ti.u64, ndim=1)):
        for i in ti.static(range(len(fields))):
            found[i] = ti.get_addr(fields[i], origins[i])

    return find

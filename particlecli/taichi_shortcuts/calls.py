"""Calls of Taichi kernels with less ado.

At each call Taichi finds out anew what each argument is, and what it has to be: some hundred microseconds on one
thread, as much as the work of many kernels. Here that is found out once for each kernel. What is no number, field or
plain array goes Taichi's own way.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum, auto
from typing import Any

import numpy as np

LARGEST = np.iinfo(np.int32).max
"""Arrays of more elements are left to Taichi, which warns of them."""


class Kind(Enum):
    """What a kernel's argument is."""

    TEMPLATE = auto()
    REAL = auto()
    INTEGER = auto()
    ARRAY = auto()
    OTHER = auto()


def take() -> None:
    """Let Taichi call kernels like that, in this process."""
    from taichi.lang import kernel_impl

    kernel, mapper = kernel_impl.Kernel, kernel_impl.TaichiCallableTemplateMapper
    kernel.launch_kernel = _launch(kernel.launch_kernel)
    mapper.extract = _extract(mapper.extract_arg)


def _kinds(arguments: list[Any]) -> list[Kind]:
    return [_kind(argument.annotation) for argument in arguments]


def _kind(annotation: Any) -> Kind:
    from taichi.lang.util import cook_dtype
    from taichi.types import primitive_types, template
    from taichi.types.ndarray_type import NdarrayType
    from taichi.types.utils import is_signed

    if isinstance(annotation, template):
        return Kind.TEMPLATE
    if id(annotation) in primitive_types.real_type_ids:
        return Kind.REAL
    if id(annotation) in primitive_types.integer_type_ids and is_signed(cook_dtype(annotation)):
        return Kind.INTEGER
    if isinstance(annotation, NdarrayType):
        plain = annotation.dtype is None or id(annotation.dtype) in primitive_types.type_ids
        return Kind.ARRAY if plain else Kind.OTHER
    return Kind.OTHER


def _launch(taichis: Callable[..., Any]) -> Callable[..., Any]:
    """As `Kernel.launch_kernel`, which is `taichis`."""
    from taichi.lang import impl

    def launch(self: Any, compiled: Any, *args: Any) -> Any:
        if not hasattr(self, "kinds"):
            self.kinds = _kinds(self.arguments)
            self.simple = self.return_type is None and not self.has_print and Kind.OTHER not in self.kinds
        context = compiled.make_launch_context() if self.simple else None
        if context is None or not _set(context, self.kinds, args):
            return taichis(self, compiled, *args)
        program = impl.get_runtime().prog
        program.launch_kernel(program.compile_kernel(program.config(), program.get_device_caps(), compiled), context)
        return None

    return launch


def _set(context: Any, kinds: list[Kind], args: tuple[Any, ...]) -> bool:
    """Set the arguments of a launch, whether or not all of them are what they seem to be."""
    place = 0
    for kind, arg in zip(kinds, args, strict=True):
        if kind is Kind.TEMPLATE:
            continue
        if kind is Kind.ARRAY:
            if type(arg) is not np.ndarray or not arg.flags.c_contiguous or arg.size > LARGEST:
                return False
            address = arg.__array_interface__["data"][0]
            context.set_arg_external_array_with_shape((place,), address, arg.nbytes, arg.shape, 0)
        elif kind is Kind.REAL:
            if not isinstance(arg, float | int | np.floating | np.integer):
                return False
            context.set_arg_float((place,), float(arg))
        else:
            if not isinstance(arg, int | np.integer):
                return False
            context.set_arg_int((place,), int(arg))
        place += 1
    return True


def _extract(taichis: Callable[..., Any]) -> Callable[..., tuple[Any, ...]]:
    """As `TaichiCallableTemplateMapper.extract`, by its `extract_arg`, which is `taichis`."""

    def extract(self: Any, args: tuple[Any, ...]) -> tuple[Any, ...]:
        if not hasattr(self, "kinds"):
            self.kinds, self.known = _kinds(self.arguments), {}
        found = []
        for place, (kind, arg) in enumerate(zip(self.kinds, args, strict=True)):
            if kind is Kind.REAL or kind is Kind.INTEGER:
                found.append("#")
                continue
            argument = self.arguments[place]
            if kind is Kind.ARRAY and type(arg) is np.ndarray:
                key = (place, arg.dtype, arg.ndim)
                if key not in self.known:
                    self.known[key] = taichis(arg, argument.annotation, argument.name)
                found.append(self.known[key])
            else:
                found.append(taichis(arg, argument.annotation, argument.name))
        return tuple(found)

    return extract

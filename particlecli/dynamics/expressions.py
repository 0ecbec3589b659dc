"""Expressions of a scene on packs: evaluated while a kernel is traced, so that they become part of it."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import taichi as ti
from taichi.lang.expr import Expr

from particlecli.dynamics import vector_math
from particlecli.scene.expression import NUMPY_FUNCTIONS, Expression


def _for_packs(name: str, on_packs: Callable[..., Any]) -> Callable[..., Any]:
    def function(*arguments: Any) -> Any:
        if any(isinstance(argument, Expr) for argument in arguments):
            return on_packs(*arguments)
        return float(NUMPY_FUNCTIONS[name](*arguments))

    return function


PACK_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    name: _for_packs(name, on_packs)
    for name, on_packs in {
        "sin": vector_math.sin,
        "cos": vector_math.cos,
        "tan": vector_math.tan,
        "exp": vector_math.exp,
        "log": vector_math.log,
        "sqrt": ti.sqrt,
        "abs": ti.abs,
        "min": vector_math.minimum,
        "max": vector_math.maximum,
        "clip": vector_math.clip,
        "floor": ti.floor,
        "where": ti.select,
        "pow": vector_math.pow,
    }.items()
}
"""What the functions of expressions mean for packs and scalars in a kernel, and for constants among them."""


def evaluate(expression: Expression, variables: Mapping[str, Any]) -> Any:
    """The value of an expression inside a kernel; its constants are frozen into the kernel.

    Args:
        expression: the expression.
        variables: a pack or scalar for each of its names.

    Returns:
        A pack where it depends on a pack, else a scalar, or a plain float where it is constant.
    """
    return expression.evaluate(variables, PACK_FUNCTIONS)


def derivatives(components: Iterable[Expression], names: Iterable[str]) -> tuple[tuple[Expression, ...], ...]:
    """The derivatives of each component with respect to each variable, a row for each component."""
    return tuple(tuple(component.derivative(name) for name in names) for component in components)


def evaluate_all(rows: Iterable[Iterable[Expression]], variables: Mapping[str, Any]) -> tuple[tuple[Any, ...], ...]:
    """The values of rows of expressions inside a kernel."""
    return tuple(tuple(evaluate(expression, variables) for expression in row) for row in rows)

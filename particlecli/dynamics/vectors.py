"""Vectors of three components while a kernel is traced; components the scene makes zero cost nothing.

As in `algebra`, a component is a pack or scalar of the kernel, or a Python number for what is known for good.
"""

from collections.abc import Sequence
from typing import TypeAlias

from taichi.lang.expr import Expr

from particlecli.dynamics.algebra import add, mul

Component: TypeAlias = Expr | float
Vector: TypeAlias = tuple[Component, Component, Component]

ZERO = (0.0,)
ZERO_AND_ONE = (0.0, 1.0, -1.0)


def structured(numbers: Sequence[float], values: Sequence[Component], literal: Sequence[float] = ZERO) -> Vector:
    """The first three of a term's parameters, those that are one of a few simple numbers as literals.

    Args:
        numbers: the parameters as the scene gives them.
        values: the parameters as the kernel has them.
        literal: numbers to compile into the kernel.
    """
    x, y, z = (number if number in literal else value for number, value in zip(numbers, values[:3], strict=True))
    return x, y, z


def scaled(factor: Component, a: Sequence[Component]) -> Vector:
    """The vector a times a factor."""
    return mul(factor, a[0]), mul(factor, a[1]), mul(factor, a[2])


def difference(a: Sequence[Component], b: Sequence[Component]) -> Vector:
    """The vector a − b."""
    return _subtract(a[0], b[0]), _subtract(a[1], b[1]), _subtract(a[2], b[2])


def cross(a: Sequence[Component], b: Sequence[Component]) -> Vector:
    """The vector product a × b."""
    return (
        _subtract(mul(a[1], b[2]), mul(a[2], b[1])),
        _subtract(mul(a[2], b[0]), mul(a[0], b[2])),
        _subtract(mul(a[0], b[1]), mul(a[1], b[0])),
    )


def _subtract(a: Component, b: Component) -> Component:
    return add(a, mul(-1.0, b))

"""3×3 matrices while a kernel is traced, as rows of components; entries the scene makes zero cost nothing.

As in `algebra`, an entry is a pack or scalar of the kernel, or a Python number for what is known for good.
"""

from collections.abc import Iterable, Sequence
from functools import reduce
from typing import TypeAlias

from particlecli.dynamics.algebra import add, bound, dot, is_literal, mul
from particlecli.dynamics.vectors import Component, Vector, scaled

Matrix: TypeAlias = tuple[Vector, Vector, Vector]

ZERO: Matrix = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def isotropic(c: Component) -> Matrix:
    """c times the unit matrix."""
    return (c, 0.0, 0.0), (0.0, c, 0.0), (0.0, 0.0, c)


def outer(a: Sequence[Component], b: Sequence[Component]) -> Matrix:
    """The matrix a bᵀ."""
    return _matrix([mul(a[i], b[j]) for j in range(3)] for i in range(3))


def radial(factor: Component, slope: Component, d: Sequence[Component]) -> Matrix:
    """The Jacobian of d ↦ f(|d|²) d.

    Args:
        factor: f.
        slope: 2 f′.
        d: the vector.
    """
    return total([isotropic(factor), outer(scaled(slope, d), d)])


def turning(n: Sequence[Component]) -> Matrix:
    """The matrix of d ↦ n × d."""
    return (0.0, mul(-1.0, n[2]), n[1]), (n[2], 0.0, mul(-1.0, n[0])), (mul(-1.0, n[1]), n[0], 0.0)


def times(factor: Component, matrix: Matrix) -> Matrix:
    """A matrix times a factor; equal entries stay the same."""
    known = {same(entry): mul(factor, entry) for row in matrix for entry in row}
    return _matrix([known[same(entry)] for entry in row] for row in matrix)


def product(a: Matrix, b: Matrix) -> Matrix:
    """The matrix product a b."""
    columns = list(zip(*b, strict=True))
    return _matrix([dot(row, column) for column in columns] for row in a)


def total(matrices: Iterable[Matrix]) -> Matrix:
    """Sum of matrices, each entry bound to a local variable, equal ones to the same; of none the zero matrix.

    Entries that are sums of the same objects are equal: the three of an isotropic matrix stay one.
    """
    terms = list(matrices)
    known: dict[tuple[object, ...], Component] = {}

    def entry(i: int, j: int) -> Component:
        parts = [matrix[i][j] for matrix in terms]
        parts = [part for part in parts if not (is_literal(part) and part == 0)]
        key = tuple(map(same, parts))
        if key not in known:
            known[key] = bound(reduce(add, parts, 0.0))
        return known[key]

    return _matrix([entry(i, j) for j in range(3)] for i in range(3))


def diagonal(matrix: Matrix) -> bool:
    """Whether all entries off the diagonal are zero for good."""
    return all(is_zero(matrix[i][j]) for i in range(3) for j in range(3) if i != j)


def is_zero(c: Component) -> bool:
    """Whether a component is zero for good."""
    return bool(is_literal(c) and c == 0)


def same(entry: Component) -> float | tuple[int]:
    """The same for components that are known to be equal."""
    return entry if is_literal(entry) else (id(entry),)


def _matrix(rows: Iterable[Iterable[Component]]) -> Matrix:
    x, y, z = (tuple(row) for row in rows)
    return x, y, z  # type: ignore[return-value]

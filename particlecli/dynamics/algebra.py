"""Algebra at trace time that leaves structural zeros and ones out of the compiled kernel.

These are plain Python functions called inside Taichi functions: they see Taichi expressions or Python numbers and
decide, while the kernel is traced, which operations it needs. A Python number stands for something known for good
(a component that is always zero, a mask that is always true), so nothing is computed for it.
"""

from functools import reduce

import taichi as ti


def is_literal(a):
    """Whether a value is known at trace time."""
    return isinstance(a, (bool, int, float))


def add(a, b):
    """a + b, without adding a literal zero."""
    if is_literal(a) and a == 0:
        return b
    if is_literal(b) and b == 0:
        return a
    return a + b


def mul(a, b):
    """a b, without multiplying by a literal 0, 1 or −1."""
    if is_literal(b) and not is_literal(a):
        a, b = b, a
    if is_literal(a):
        if a == 0:
            return 0.0
        if a == 1:
            return b
        if a == -1:
            return -b
    return a * b


def dot(a, b):
    """Scalar product of two sequences."""
    return reduce(add, (mul(x, y) for x, y in zip(a, b, strict=True)), 0.0)


def total(terms):
    """Sum of vectors of three components, each component bound to a local variable; of none the literal zero."""
    return [bound(reduce(add, (term[c] for term in terms), 0.0)) for c in range(3)]


def combination(base, step, weights, slopes):
    """base + step Σ weights[j] slopes[j], component by component; zero weights cost nothing."""
    return [bound(add(value, mul(step, dot(weights, [slope[c] for slope in slopes])))) for c, value in enumerate(base)]


def both(a, b):
    """Logical and of two masks, either of which may be the literal True."""
    if a is True:
        return b
    if b is True:
        return a
    return a & b


def choose(mask, a, b):
    """a where the mask holds, else b; the mask may be the literal True."""
    return a if mask is True else ti.select(mask, a, b)


def bound(a):
    """The value in a local variable, so that its expression is evaluated once."""
    return a if is_literal(a) else _bind(a)


@ti.func
def _bind(a):
    local = a
    return local


@ti.func
def finite(state):
    """Mask of the lanes, or whether for a single particle, every component is finite."""
    zero = 0.0 * state[0]
    for i in ti.static(range(1, 6)):
        zero = zero + 0.0 * state[i]
    return zero == 0.0

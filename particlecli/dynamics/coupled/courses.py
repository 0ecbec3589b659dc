"""Where pinned particles are told to be, how fast they go there, and how fast that changes; while a kernel is traced.

Symbols: a frame takes x to M x + T, M = s R; see `scene.poses`. Along a chain M = M₁ M₂ and T = T₁ + M₁ T₂, and the
k-th derivative of a product is Σᵢ (k over i) a⁽ⁱ⁾ b⁽ᵏ⁻ⁱ⁾ (Leibniz).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from math import comb
from typing import NamedTuple, TypeVar

from particlecli.dynamics.algebra import bound, mul
from particlecli.dynamics.expressions import PACK_FUNCTIONS, evaluate
from particlecli.dynamics.matrices import ZERO, Matrix, product, times, total
from particlecli.dynamics.riding import NOWHERE, UNIT, applied, plus, rotation_parts
from particlecli.dynamics.vectors import Component, Vector, scaled
from particlecli.scene.expression import Expression
from particlecli.scene.frames import Chain, CoordinateFrame

A = TypeVar("A")
B = TypeVar("B")
C = TypeVar("C")

HIGHEST = 2
"""Positions, velocities and accelerations are asked for."""


class Affine(NamedTuple):
    """x ↦ M x + T, or a derivative of it by time."""

    matrix: Matrix
    shift: Vector


@dataclass(frozen=True)
class Course:
    """The way of pinned particles.

    Attributes:
        path: x, y, z, m, as expressions of t and of where they are at first; none: they stay there.
        ride: the frames from the world to the one in which all this is.
    """

    path: tuple[Expression, Expression, Expression] | None
    ride: Chain

    @property
    def moves(self) -> bool:
        """Whether it leads anywhere."""
        return self.path is not None or bool(self.ride)

    def at(self, anchor: Vector, t: Component, order: int) -> list[Component]:
        """Derivatives of the position by time, of orders `order` and `order` + 1, six components.

        Args:
            anchor: where the particles are at first, in the frame, m; packs.
            t: s.
            order: 0 for positions and velocities, 1 for velocities and accelerations.
        """
        last = order + 1
        places = self._within(anchor, t, last)
        frames = _frames(self.ride, t, last) if self.ride else None
        found: list[Component] = []
        for k in (order, last):
            found += places[k] if frames is None else _point(frames, places, k)
        return found

    def _within(self, anchor: Vector, t: Component, last: int) -> list[Vector]:
        """Derivatives of the position in the frame, of orders 0 to `last`."""
        if self.path is None:
            return [anchor, *[NOWHERE] * last]
        names = {**dict(zip("xyz", anchor, strict=True)), "t": t}
        x, y, z = (_derivatives(component, names, last) for component in self.path)
        return list(zip(x, y, z, strict=True))


def _frames(ride: Chain, t: Component, last: int) -> list[Affine]:
    """The last frame of a chain in the world, and its derivatives."""
    here = [Affine(UNIT, NOWHERE), *[Affine(ZERO, NOWHERE)] * last]
    for frame in ride:
        inner = _local(frame, t, last)
        matrices, inners = [each.matrix for each in here], [each.matrix for each in inner]
        shifts = [each.shift for each in inner]
        here = [Affine(total(_leibniz(product, times, matrices, inners, k)), _point(here, shifts, k))
                for k in range(last + 1)]  # fmt: skip
    return here


def _point(frames: Sequence[Affine], places: Sequence[Vector], k: int) -> Vector:
    """The k-th derivative of a point whose place in a frame changes."""
    matrices = [each.matrix for each in frames]
    return reduce(plus, _leibniz(applied, scaled, matrices, places, k), frames[k].shift)


def _local(frame: CoordinateFrame, t: Component, last: int) -> list[Affine]:
    """A frame in its parent, and its derivatives."""
    scales = _derivatives(frame.scale, {"t": t}, last)
    rotations = _rotations(frame, t)
    x, y, z = (_derivatives(component, {"t": t}, last) for component in frame.translate)
    return [
        Affine(total(_leibniz(times, times, scales, rotations, k)), shift)
        for k, shift in enumerate(zip(x, y, z, strict=True))
    ]


def _rotations(frame: CoordinateFrame, t: Component) -> list[Matrix]:
    """R and its first derivatives: with c, s = cos θ, sin θ it is c F + s C + a aᵀ (Rodrigues)."""
    if frame.rotate is None:
        return [UNIT, *[ZERO] * HIGHEST]
    angle, speed, change = _derivatives(frame.rotate.angle, {"t": t}, HIGHEST)
    cosine, sine = bound(PACK_FUNCTIONS["cos"](angle)), bound(PACK_FUNCTIONS["sin"](angle))
    flat, cross, square = rotation_parts(frame.rotate.axis)
    turned = total([times(cosine, flat), times(sine, cross)])
    ahead = total([times(cosine, cross), times(mul(-1.0, sine), flat)])
    squared = mul(-1.0, mul(speed, speed))
    return [total([turned, square]), times(speed, ahead), total([times(change, ahead), times(squared, turned)])]


def _derivatives(expression: Expression, names: dict[str, Component], last: int) -> list[Component]:
    found = []
    for _ in range(last + 1):
        found.append(bound(evaluate(expression, names)))
        expression = expression.derivative("t")
    return found


def _leibniz(
    by: Callable[[A, B], C], weighted: Callable[[float, C], C], a: Sequence[A], b: Sequence[B], k: int
) -> list[C]:
    """The terms of the k-th derivative of a product, of which a and b are the derivatives of the factors."""
    return [weighted(float(comb(k, i)), by(a[i], b[k - i])) for i in range(k + 1)]

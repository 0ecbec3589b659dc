"""Poses of coordinate frames inside kernels, and their rates of change; see `frames` for the same on the host.

Vectors and matrices hold packs or scalars of the kernel, or Python numbers for what is known for good.
"""

from typing import NamedTuple

from particlecli.dynamics.algebra import add, bound, dot, mul
from particlecli.dynamics.expressions import PACK_FUNCTIONS, evaluate
from particlecli.dynamics.matrices import ZERO, Matrix, isotropic, outer, product, times, total, turning
from particlecli.dynamics.vectors import Component, Vector, difference, scaled
from particlecli.scene.expression import Expression
from particlecli.scene.frames import Chain, CoordinateFrame
from particlecli.scene.types import Vector3

UNIT = isotropic(1.0)
NOWHERE = (0.0, 0.0, 0.0)


class Pose(NamedTuple):
    """x ↦ T + s R x, or its rate of change: `scale` s, `rotation` R, `shift` T."""

    scale: Component
    rotation: Matrix
    shift: Vector

    def point(self, x: Vector) -> Vector:
        """Where a point given in the frame is, m."""
        return plus(self.shift, scaled(self.scale, applied(self.rotation, x)))

    def unturned(self, x: Vector) -> Vector:
        """Rᵀ (x − T)."""
        return applied(transposed(self.rotation), difference(x, self.shift))


AT_HOME = Pose(1.0, UNIT, NOWHERE)
AT_REST = Pose(0.0, ZERO, NOWHERE)


def pose(ride: Chain, t: Component) -> Pose:
    """The pose in the world of the last frame of a chain at a time, s."""
    here = AT_HOME
    for frame in ride:
        here = _composed(here, _local(frame, t))
    return here


def pose_and_rate(ride: Chain, t: Component) -> tuple[Pose, Pose]:
    """The pose, and its rate of change by the product rule."""
    here, rate = AT_HOME, AT_REST
    for frame in ride:
        inner, change = _local(frame, t), _local_rate(frame, t)
        lever = applied(here.rotation, inner.shift)
        sweep = plus(applied(rate.rotation, inner.shift), applied(here.rotation, change.shift))
        rate = Pose(
            _sum(mul(rate.scale, inner.scale), mul(here.scale, change.scale)),
            total([product(rate.rotation, inner.rotation), product(here.rotation, change.rotation)]),
            plus(rate.shift, plus(scaled(rate.scale, lever), scaled(here.scale, sweep))),
        )
        here = _composed(here, inner)
    return here, rate


def velocity_at(here: Pose, rate: Pose, x: Vector) -> Vector:
    """How fast that point of a moving frame goes which is at x in the world, m/s."""
    unturned = here.unturned(x)
    stretching = scaled(_over(rate.scale, here.scale), applied(here.rotation, unturned))
    return plus(rate.shift, plus(stretching, applied(rate.rotation, unturned)))


def _composed(here: Pose, inner: Pose) -> Pose:
    scale = bound(mul(here.scale, inner.scale))
    return Pose(scale, product(here.rotation, inner.rotation), here.point(inner.shift))


def _local(frame: CoordinateFrame, t: Component) -> Pose:
    x, y, z = (evaluate(component, {"t": t}) for component in frame.translate)
    rotation = UNIT
    if frame.rotate is not None:
        cosine, sine = _turn(frame.rotate.angle, t)
        flat, cross, square = rotation_parts(frame.rotate.axis)
        rotation = total([times(cosine, flat), times(sine, cross), square])
    return Pose(evaluate(frame.scale, {"t": t}), rotation, (x, y, z))


def _local_rate(frame: CoordinateFrame, t: Component) -> Pose:
    x, y, z = (_rate(component, t) for component in frame.translate)
    rotation = ZERO
    if frame.rotate is not None:
        cosine, sine = _turn(frame.rotate.angle, t)
        flat, cross, _ = rotation_parts(frame.rotate.axis)
        turned = total([times(mul(-1.0, sine), flat), times(cosine, cross)])
        rotation = times(_rate(frame.rotate.angle, t), turned)
    return Pose(_rate(frame.scale, t), rotation, (x, y, z))


def rotation_parts(axis: Vector3) -> tuple[Matrix, Matrix, Matrix]:
    """I − a aᵀ, [a]× and a aᵀ of Rodrigues' formula R = cos (I − a aᵀ) + sin [a]× + a aᵀ."""
    square = outer(axis, axis)
    return total([UNIT, times(-1.0, square)]), turning(axis), square


def _turn(angle: Expression, t: Component) -> tuple[Component, Component]:
    value = bound(evaluate(angle, {"t": t}))
    return bound(PACK_FUNCTIONS["cos"](value)), bound(PACK_FUNCTIONS["sin"](value))


def _rate(expression: Expression, t: Component) -> Component:
    return bound(evaluate(expression.derivative("t"), {"t": t}))


def _over(a: Component, b: Component) -> Component:
    return a if b == 1.0 else a / b


def _sum(a: Component, b: Component) -> Component:
    return bound(add(a, b))


def applied(matrix: Matrix, vector: Vector) -> Vector:
    """A matrix times a vector."""
    x, y, z = (bound(dot(row, vector)) for row in matrix)
    return x, y, z


def plus(a: Vector, b: Vector) -> Vector:
    """The sum of two vectors."""
    x, y, z = (_sum(p, q) for p, q in zip(a, b, strict=True))
    return x, y, z


def transposed(matrix: Matrix) -> Matrix:
    """The transpose; of a rotation the inverse."""
    x, y, z = zip(*matrix, strict=True)
    return x, y, z

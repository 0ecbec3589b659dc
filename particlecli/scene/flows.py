"""Velocity fields u(x, t) of the surrounding medium. The terms of a named flow add up."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from particlecli.scene.expression import Expression, Uses
from particlecli.scene.types import (
    Direction,
    NonNegative,
    Positive,
    Real,
    SceneModel,
    Vector3,
    Whole,
    described,
)

FlowExpression = Annotated[Expression, Uses("x", "y", "z", "t")]


class UniformFlow(SceneModel):
    """The same velocity everywhere: u = velocity."""

    type: Literal["uniform"]
    velocity: Vector3 = described("u, m/s")


class VortexFlow(SceneModel):
    """Lamb–Oseen vortex about an axis: circumferential speed circulation / (2πr) (1 − exp(−r²/core²))."""

    type: Literal["vortex"]
    center: Vector3 = described("a point on the axis, m", default=(0.0, 0.0, 0.0))
    axis: Direction = described("direction of the axis; turns right-handed about it", default=(0.0, 1.0, 0.0))
    circulation: Real = described("m²/s; its sign turns the sense of rotation")
    core: Positive = described("core radius, m; inside, the fluid turns almost like a rigid body", default=0.1)


class CurlNoiseFlow(SceneModel):
    """Divergence-free turbulence: the curl of a random Fourier potential that evolves in time."""

    type: Literal["curl_noise"]
    length: Positive = described("size of the largest eddies (wavelength), m")
    speed: NonNegative = described("root-mean-square speed of all octaves together, m/s")
    octaves: Whole = described("scales of eddies, each half the size of the one before", default=3, ge=1, le=8)
    lifetime: Positive | None = described(
        "time in which the largest eddies change, s; smaller ones change faster; none: frozen", default=None
    )
    seed: Whole = described("another number, another turbulence of the same kind", default=0, ge=0)


class AbcFlow(SceneModel):
    """Arnold–Beltrami–Childress flow: u = (A sin kz + C cos ky, B sin kx + A cos kz, C sin ky + B cos kx)."""

    type: Literal["abc"]
    amplitudes: Vector3 = described("A, B, C, m/s", default=(1.0, 1.0, 1.0))
    wave_number: Positive = described("k, rad/m; the flow repeats after 2π/k", default=1.0)


class DoubleGyreFlow(SceneModel):
    """Two counter-rotating gyres side by side in 0 ≤ x ≤ 2L, 0 ≤ y ≤ L, whose border swings."""

    type: Literal["double_gyre"]
    amplitude: Real = described("A, m/s; the fastest is πA", default=0.1)
    swing: NonNegative = described("ε, how far the border swings to both sides, parts of L", default=0.25)
    period: Positive = described("of the swinging, s", default=10.0)
    length: Positive = described("L, side of a gyre, m", default=1.0)


class TaylorGreenFlow(SceneModel):
    """Taylor–Green vortices: u = speed exp(−2νk²t) (sin kx cos ky, −cos kx sin ky, 0), k = 2π/length."""

    type: Literal["taylor_green"]
    speed: Real = described("largest speed at t = 0, m/s", default=1.0)
    length: Positive = described("wavelength, m; a vortex is half as wide", default=1.0)
    viscosity: NonNegative = described("ν, kinematic, m²/s; 0: steady", default=0.0)


class ExpressionFlow(SceneModel):
    """Any velocity field, written out: three expressions of x, y, z, t."""

    type: Literal["expression"]
    velocity: tuple[FlowExpression, FlowExpression, FlowExpression] = described("m/s; expressions of x, y, z, t")


FlowTerm = Annotated[
    UniformFlow | VortexFlow | CurlNoiseFlow | AbcFlow | DoubleGyreFlow | TaylorGreenFlow | ExpressionFlow,
    Field(discriminator="type"),
]

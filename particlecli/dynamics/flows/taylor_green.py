"""A chessboard of whirls that viscosity slows down."""

import math

import taichi as ti

from particlecli.dynamics.flows.base import FlowTerm
from particlecli.dynamics.vector_math import cos, exp, sin
from particlecli.scene import flows as scene


class TaylorGreen(FlowTerm[scene.TaylorGreenFlow]):
    """u = U exp(−2νk²t) (sin kx cos ky, −cos kx sin ky, 0), k = 2π/L.

    Symbols: U speed at t = 0, m/s; L wavelength, m: a whirl is half as wide; ν kinematic viscosity, m²/s.
    An exact solution of the Navier–Stokes equations; its divergence is zero.
    Source: Taylor, Phil. Mag. 46 (1923) 671; Taylor & Green, Proc. R. Soc. A 158 (1937) 499.
    """

    def parameters(self) -> list[float]:
        """The speed U, the wave number k, and the rate of decay 2νk²."""
        k = math.tau / self.spec.length
        return [self.spec.speed, k, 2 * self.spec.viscosity * k**2]

    @ti.func
    def _speed(self, p, t):
        if ti.static(self.spec.viscosity == 0):
            return p[0]
        return p[0] * exp(-p[2] * t)

    @ti.func
    def velocity(self, p, x, t):
        """The velocity, m/s."""
        a, b, speed = p[1] * x[0], p[1] * x[1], self._speed(p, t)
        return speed * sin(a) * cos(b), -speed * cos(a) * sin(b), 0.0

    @ti.func
    def gradient(self, p, x, t):
        """The derivatives by position, 1/s."""
        a, b, rate = p[1] * x[0], p[1] * x[1], p[1] * self._speed(p, t)
        stretching, turning = rate * cos(a) * cos(b), rate * sin(a) * sin(b)
        return (stretching, -turning, 0.0), (turning, -stretching, 0.0), (0.0, 0.0, 0.0)

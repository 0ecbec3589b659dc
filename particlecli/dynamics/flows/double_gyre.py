"""Two whirls side by side whose border swings to and fro."""

import math

import taichi as ti

from particlecli.dynamics.flows.base import FlowTerm
from particlecli.dynamics.vector_math import cos, sin
from particlecli.scene import flows as scene


class DoubleGyre(FlowTerm[scene.DoubleGyreFlow]):
    """u = −πA sin(πf) cos(πη), v = πA cos(πf) sin(πη) ∂f/∂ξ, f = s ξ² + (1 − 2s) ξ, s = ε sin(2πt/T).

    Symbols: ξ = x/L, η = y/L; A amplitude, m/s; ε how far the border swings, parts of L; T period, s; L side
    of a gyre, m. They fill 0 ≤ x ≤ 2L, 0 ≤ y ≤ L; the divergence is zero everywhere.
    Source: Shadden, Lekien & Marsden, Physica D 212 (2005) 271.
    """

    def parameters(self) -> list[float]:
        """π A, ε, the angular frequency 2π/T, and 1/L."""
        spec = self.spec
        return [math.pi * spec.amplitude, spec.swing, math.tau / spec.period, 1 / spec.length]

    @ti.func
    def _warped(self, p, x, t):
        """s, f, ∂f/∂ξ."""
        s = p[1] * sin(p[2] * t)
        across = x[0] * p[3]
        return s, (s * across + (1.0 - 2.0 * s)) * across, 2.0 * s * (across - 1.0) + 1.0

    @ti.func
    def velocity(self, p, x, t):
        """The velocity, m/s."""
        _, f, slope = self._warped(p, x, t)
        a, b = math.pi * f, math.pi * (x[1] * p[3])
        return -p[0] * sin(a) * cos(b), p[0] * cos(a) * sin(b) * slope, 0.0

    @ti.func
    def gradient(self, p, x, t):
        """The derivatives by position, 1/s."""
        s, f, slope = self._warped(p, x, t)
        a, b = math.pi * f, math.pi * (x[1] * p[3])
        factor = p[0] * p[3]
        stretching = math.pi * factor * cos(a) * cos(b) * slope
        upwards = factor * (2.0 * s * cos(a) - math.pi * slope * slope * sin(a)) * sin(b)
        return (
            (-stretching, math.pi * factor * sin(a) * sin(b), 0.0),
            (upwards, stretching, 0.0),
            (0.0, 0.0, 0.0),
        )

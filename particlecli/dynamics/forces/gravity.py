"""Uniform gravity."""

import taichi as ti

from particlecli.dynamics.algebra import dot
from particlecli.dynamics.forces.base import ForceTerm
from particlecli.dynamics.matrices import ZERO
from particlecli.dynamics.vectors import structured
from particlecli.scene import forces as scene


class Gravity(ForceTerm[scene.Gravity]):
    """a = g, U/m = −g · x.

    Symbols: g acceleration of free fall, m/s². Source: Galilei, "Discorsi" (1638), third day.
    """

    has_potential = True

    def parameters(self) -> list[float]:
        """The acceleration g."""
        return list(self.spec.acceleration)

    @ti.func
    def acceleration(self, p, x, v, u, t, inverse_mass):
        """The acceleration, m/s²."""
        return ti.static(structured(self.spec.acceleration, p))

    @ti.func
    def jacobian(self, p, x, v, u, gradient, t, inverse_mass):
        """The derivatives by position, 1/s², and velocity, 1/s: none."""
        return ZERO, ZERO

    @ti.func
    def potential(self, p, x, t, inverse_mass):
        """The potential energy by mass, J/kg; zero at the origin."""
        return -dot(structured(self.spec.acceleration, p), x)

"""Drag of a fast body."""

import taichi as ti

from particlecli.dynamics.algebra import dot
from particlecli.dynamics.forces.base import ForceTerm
from particlecli.dynamics.forces.drag import carried, relative
from particlecli.dynamics.matrices import radial
from particlecli.dynamics.vectors import scaled
from particlecli.scene import forces as scene

TINY = 1e-30
"""Speed that keeps the quotient of two vanishing speeds finite, m/s."""


class QuadraticDrag(ForceTerm[scene.QuadraticDrag]):
    """F = k |u − v| (u − v).

    Symbols: k coefficient, kg/m (½ ρ c_d A of a body of area A and drag coefficient c_d in a medium of
    density ρ); u velocity of the medium, m/s; v the particle's, m/s.
    Source: Newton, "Principia" (1687), book II.
    """

    def parameters(self) -> list[float]:
        """The coefficient k."""
        return [self.spec.coefficient]

    @ti.func
    def acceleration(self, p, x, v, u, t, inverse_mass):
        """The acceleration, m/s²."""
        wind = ti.static(relative(v, u, self.spec))
        rate = -p[0] * inverse_mass * ti.sqrt(dot(wind, wind))
        return ti.static(scaled(rate, wind))

    @ti.func
    def jacobian(self, p, x, v, u, gradient, t, inverse_mass):
        """The derivatives by position, 1/s², and velocity, 1/s."""
        wind = ti.static(relative(v, u, self.spec))
        speed = ti.sqrt(dot(wind, wind))
        coefficient = -p[0] * inverse_mass
        steeper = coefficient / ti.max(speed, TINY)
        by_velocity = ti.static(radial(coefficient * speed, steeper, wind))
        return ti.static(carried(by_velocity, gradient, self.spec))

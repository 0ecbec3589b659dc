"""Gravity of a mass at a point."""

import taichi as ti

from particlecli.dynamics.algebra import add, dot
from particlecli.dynamics.forces.base import ForceTerm
from particlecli.dynamics.matrices import ZERO, radial
from particlecli.dynamics.vectors import difference, scaled, structured
from particlecli.scene import forces as scene


class PointGravity(ForceTerm[scene.PointGravity]):
    """a = −GM d / (|d|² + ε²)^(3/2), U/m = −GM / (|d|² + ε²)^(1/2); a = 0 where |d| < cutoff.

    Symbols: d = x − center, m; GM gravitational constant times mass, m³/s² (negative: it repels); ε
    softening, m.
    Within the cutoff the potential is what it is at the cutoff, so that it is continuous.
    Source: Newton, "Principia" (1687), book I, prop. XI; softening after Plummer, MNRAS 71 (1911) 460.
    """

    has_potential = True

    def parameters(self) -> list[float]:
        """Center (3), GM, ε², cutoff²."""
        return [*self.spec.center, self.spec.strength, self.spec.softening**2, self.spec.cutoff**2]

    def _offset(self, p, x):
        return difference(x, structured(self.spec.center, p))

    def _softened(self, p, distance2):
        return add(distance2, p[4] if self.spec.softening else 0.0)

    @ti.func
    def acceleration(self, p, x, v, u, t, inverse_mass):
        """The acceleration, m/s²."""
        d = ti.static(self._offset(p, x))
        distance2 = dot(d, d)
        softened2 = self._softened(p, distance2)
        factor = -p[3] / (softened2 * ti.sqrt(softened2))
        return ti.static(scaled(self._outside(p, distance2, factor), d))

    @ti.func
    def jacobian(self, p, x, v, u, gradient, t, inverse_mass):
        """The derivatives by position, 1/s², and velocity, 1/s; without the jump at the cutoff."""
        d = ti.static(self._offset(p, x))
        distance2 = dot(d, d)
        softened2 = self._softened(p, distance2)
        factor = -p[3] / (softened2 * ti.sqrt(softened2))
        steeper = self._outside(p, distance2, -3.0 * factor / softened2)
        return ti.static(radial(self._outside(p, distance2, factor), steeper, d)), ZERO

    @ti.func
    def _outside(self, p, distance2, value):
        """The value beyond the cutoff, zero within."""
        if ti.static(self.spec.cutoff > 0):
            return ti.select(distance2 < p[5], 0.0, value)
        return value

    @ti.func
    def potential(self, p, x, t, inverse_mass):
        """The potential energy by mass, J/kg; zero far away."""
        d = ti.static(self._offset(p, x))
        distance2 = dot(d, d)
        if ti.static(self.spec.cutoff > 0):
            distance2 = ti.max(distance2, p[5])
        return -p[3] / ti.sqrt(self._softened(p, distance2))

"""Attraction to a point that falls with a power of the distance."""

import taichi as ti

from particlecli.dynamics.algebra import dot
from particlecli.dynamics.expressions import evaluate
from particlecli.dynamics.forces.base import ForceTerm
from particlecli.dynamics.matrices import ZERO, radial
from particlecli.dynamics.vector_math import log
from particlecli.dynamics.vectors import difference, scaled, structured
from particlecli.scene import forces as scene
from particlecli.scene.expression import Expression


class Orbit(ForceTerm[scene.OrbitForce]):
    """a = −K d / s^((n+1)/2) with s = |d|² + c²; U/m = K / (1 − n) s^((1−n)/2), or ½ K ln s where n = 1.

    Symbols: d = x − center, m; K strength, m^(n+1)/s²; n exponent; c core, m, within which it fades.
    The exponent decides which products and roots there are, so it is compiled into the kernel.
    Source: McAllister, "The design of an API for particle systems", UNC-CH TR00-007 (2000), OrbitPoint.
    """

    has_potential = True

    def parameters(self) -> list[float]:
        """Center (3), strength, c², factor of the potential."""
        n, strength = self.spec.exponent, self.spec.strength
        of_potential = strength / 2 if n == 1 else strength / (1 - n)
        return [*self.spec.center, strength, self.spec.core**2, of_potential]

    def _offset(self, p, x):
        return difference(x, structured(self.spec.center, p))

    @ti.func
    def acceleration(self, p, x, v, u, t, inverse_mass):
        """The acceleration, m/s²."""
        d = ti.static(self._offset(p, x))
        factor = -p[3] / _power(dot(d, d) + p[4], (self.spec.exponent + 1) / 2)
        return ti.static(scaled(factor, d))

    @ti.func
    def jacobian(self, p, x, v, u, gradient, t, inverse_mass):
        """The derivatives by position, 1/s², and velocity, 1/s."""
        d = ti.static(self._offset(p, x))
        s = dot(d, d) + p[4]
        factor = -p[3] / _power(s, (self.spec.exponent + 1) / 2)
        steeper = -(self.spec.exponent + 1) * factor / s
        return ti.static(radial(factor, steeper, d)), ZERO

    @ti.func
    def potential(self, p, x, t, inverse_mass):
        """The potential energy by mass, J/kg."""
        d = ti.static(self._offset(p, x))
        s = dot(d, d) + p[4]
        if ti.static(self.spec.exponent == 1):
            return p[5] * log(s)
        return p[5] * _power(s, (1 - self.spec.exponent) / 2)


def _power(base, exponent):
    return evaluate(Expression(f"base**{exponent!r}"), {"base": base})

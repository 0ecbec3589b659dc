"""A whirl about an axis, as acceleration."""

import taichi as ti

from particlecli.dynamics import algebra
from particlecli.dynamics.algebra import add, bound, dot, mul
from particlecli.dynamics.forces.base import ForceTerm
from particlecli.dynamics.matrices import ZERO, outer, product, times, total, turning
from particlecli.dynamics.vector_math import log
from particlecli.dynamics.vectors import ZERO_AND_ONE, cross, difference, scaled, structured
from particlecli.scene import forces as scene


class Vortex(ForceTerm[scene.VortexForce]):
    """a = (s n × ρ − q ρ) / (|ρ|² + c²); without swirl U/m = ½ q ln(|ρ|² + c²).

    Symbols: ρ the offset from the axis, m; n unit vector along the axis; s swirl, m²/s²; q pull towards the
    axis, m²/s²; c core, m, within which it fades. Source: vortex operator of Sims, "Particle animation and
    rendering using data parallel computation", SIGGRAPH 1990.
    """

    def __init__(self, spec: scene.VortexForce) -> None:
        super().__init__(spec)
        self.has_potential = spec.swirl == 0

    def parameters(self) -> list[float]:
        """Center (3), axis (3), swirl, pull, c²."""
        spec = self.spec
        return [*spec.center, *spec.axis, spec.swirl, spec.pull, spec.core**2]

    def _axis(self, p):
        return structured(self.spec.axis, p[3:], ZERO_AND_ONE)

    def _around(self, p, x):
        """n × ρ, which is n × d for every offset d from a point on the axis."""
        return cross(self._axis(p), difference(x, structured(self.spec.center, p)))

    @ti.func
    def acceleration(self, p, x, v, u, t, inverse_mass):
        """The acceleration, m/s²."""
        around = ti.static(self._around(p, x))
        inverse = 1.0 / (dot(around, around) + p[8])
        swirl = ti.static(scaled(p[6] * inverse, around))
        if ti.static(self.spec.pull == 0):
            return swirl
        inward = ti.static(cross(self._axis(p), around))
        return algebra.total([swirl, scaled(p[7] * inverse, inward)])

    @ti.func
    def jacobian(self, p, x, v, u, gradient, t, inverse_mass):
        """The derivatives by position, 1/s², and velocity, 1/s."""
        around = ti.static(self._around(p, x))
        inward = ti.static(cross(self._axis(p), around))
        inverse = 1.0 / (dot(around, around) + p[8])
        pull = p[7] if ti.static(self.spec.pull != 0) else 0.0
        return ti.static(self._slopes(p, around, inward, inverse, pull)), ZERO

    def _slopes(self, p, around, inward, inverse, pull):
        """∂a/∂x of a = (s A + q A²) d / (|A d|² + c²) with A the matrix of n ×, A d = n × ρ and A² d = −ρ."""
        turn = turning(self._axis(p))
        whirl = total([times(p[6], turn), times(pull, product(turn, turn))])
        acceleration = [bound(add(mul(p[6], a), mul(pull, b))) for a, b in zip(around, inward, strict=True)]
        fading = scaled(bound(2.0 * inverse * inverse), inward)
        return total([times(inverse, whirl), outer(acceleration, fading)])

    @ti.func
    def potential(self, p, x, t, inverse_mass):
        """The potential energy by mass, J/kg."""
        around = ti.static(self._around(p, x))
        return 0.5 * p[7] * log(dot(around, around) + p[8])

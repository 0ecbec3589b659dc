"""A force or potential written out in the scene."""

from functools import cached_property

import taichi as ti

from particlecli.dynamics.algebra import mul
from particlecli.dynamics.expressions import derivatives, evaluate, evaluate_all
from particlecli.dynamics.forces.base import ForceTerm
from particlecli.dynamics.matrices import ZERO, times
from particlecli.dynamics.vectors import scaled
from particlecli.scene import forces as scene


class ForceField(ForceTerm[scene.ForceField]):
    """F = (f, g, h), or F = −∇U.

    Symbols: f, g, h the scene's expressions, N, of the position x, y, z, m, the velocity u, v, w, m/s, and
    the time t, s; U its potential, J, an expression of x, y, z, t, differentiated symbolically.
    """

    def __init__(self, spec: scene.ForceField) -> None:
        super().__init__(spec)
        self.has_potential = spec.potential is not None
        self.slopes = () if spec.potential is None else tuple(map(spec.potential.derivative, "xyz"))

    @cached_property
    def _stiffness(self):
        """The derivatives of the force, or of the potential's slope, by position."""
        return derivatives(self.spec.force or self.slopes, "xyz")

    @cached_property
    def _damping(self):
        return derivatives(self.spec.force or (), "uvw")

    def _force(self, x, v, t):
        names = dict(zip("xyzuvwt", (*x, *v, t), strict=True))
        if self.spec.force is not None:
            return tuple(evaluate(component, names) for component in self.spec.force)
        return scaled(-1.0, [evaluate(slope, names) for slope in self.slopes])

    def _energy(self, x, t):
        return evaluate(self.spec.potential, dict(zip("xyzt", (*x, t), strict=True)))

    @ti.func
    def acceleration(self, p, x, v, u, t, inverse_mass):
        """The acceleration, m/s²."""
        return ti.static(scaled(inverse_mass, self._force(x, v, t)))

    @ti.func
    def jacobian(self, p, x, v, u, gradient, t, inverse_mass):
        """The derivatives by position, 1/s², and velocity, 1/s."""
        return ti.static(self._derivatives(x, v, t, inverse_mass))

    def _derivatives(self, x, v, t, inverse_mass):
        names = dict(zip("xyzuvwt", (*x, *v, t), strict=True))
        by_position = evaluate_all(self._stiffness, names)
        if self.has_potential:
            return times(mul(-1.0, inverse_mass), by_position), ZERO
        return times(inverse_mass, by_position), times(inverse_mass, evaluate_all(self._damping, names))

    @ti.func
    def potential(self, p, x, t, inverse_mass):
        """The potential energy by mass, J/kg."""
        return mul(inverse_mass, self._energy(x, t))

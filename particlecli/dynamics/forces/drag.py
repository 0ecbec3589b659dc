"""Drag in a viscous medium."""

import taichi as ti

from particlecli.dynamics.forces.base import ForceTerm
from particlecli.dynamics.matrices import ZERO, isotropic, product, times
from particlecli.dynamics.vectors import difference, scaled
from particlecli.scene import forces as scene


class Drag(ForceTerm[scene.Drag]):
    """F = k (u − v).

    Symbols: k coefficient, kg/s (6π η r for a small sphere of radius r in a medium of viscosity η); u
    velocity of the medium, m/s; v the particle's, m/s.
    Source: Stokes, Trans. Cambridge Phil. Soc. 9 (1851) 8.
    """

    def parameters(self) -> list[float]:
        """The coefficient k."""
        return [self.spec.coefficient]

    @ti.func
    def acceleration(self, p, x, v, u, t, inverse_mass):
        """The acceleration, m/s²."""
        wind = ti.static(relative(v, u, self.spec))
        return ti.static(scaled(-p[0] * inverse_mass, wind))

    @ti.func
    def jacobian(self, p, x, v, u, gradient, t, inverse_mass):
        """The derivatives by position, 1/s², and velocity, 1/s."""
        rate = p[0] * inverse_mass
        return ti.static(carried(isotropic(-rate), gradient, self.spec))


def relative(v, u, spec):
    """The particle's velocity in the medium, which is at rest where the force names no flow."""
    return difference(v, u) if spec.flow else v


def carried(by_velocity, gradient, spec):
    """The derivatives of a drag by position and velocity, given that by velocity.

    It depends on the position through the medium alone.
    """
    by_position = times(-1.0, product(by_velocity, gradient)) if spec.flow else ZERO
    return by_position, by_velocity

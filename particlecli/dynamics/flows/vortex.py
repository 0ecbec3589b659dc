"""The vortex of a viscous fluid about a straight axis."""

import math

import taichi as ti

from particlecli.dynamics.algebra import dot
from particlecli.dynamics.flows.base import FlowTerm
from particlecli.dynamics.matrices import outer, times, total, turning
from particlecli.dynamics.vector_math import mean_decay, mean_decay_slope
from particlecli.dynamics.vectors import ZERO_AND_ONE, cross, difference, scaled, structured
from particlecli.scene import flows as scene


class Vortex(FlowTerm[scene.VortexFlow]):
    """u = Γ / (2π r²) (1 − exp(−r²/c²)) n × d, with r = |n × d| the distance from the axis.

    Symbols: d = x − center, m; n unit vector along the axis; Γ circulation, m²/s; c core radius, m.
    On the axis it is a rotation of angular speed Γ / (2π c²); far away it is the potential vortex Γ / (2π r).
    Source: Lamb, "Hydrodynamics", 6th ed., § 334a (with c² = 4νt); Oseen, Ark. Mat. Astron. Fys. 7 (1912).
    """

    def parameters(self) -> list[float]:
        """Center (3), axis (3), angular speed on the axis, 1/c²."""
        inverse_core2 = 1 / self.spec.core**2
        spin = self.spec.circulation / (2 * math.pi) * inverse_core2
        return [*self.spec.center, *self.spec.axis, spin, inverse_core2]

    @ti.func
    def velocity(self, p, x, t):
        """The velocity, m/s."""
        d = ti.static(difference(x, structured(self.spec.center, p)))
        around = ti.static(cross(structured(self.spec.axis, p[3:], ZERO_AND_ONE), d))
        spin = p[6] * mean_decay(dot(around, around) * p[7])
        return ti.static(scaled(spin, around))

    @ti.func
    def gradient(self, p, x, t):
        """The derivatives by position, 1/s."""
        axis = ti.static(structured(self.spec.axis, p[3:], ZERO_AND_ONE))
        around = ti.static(cross(axis, difference(x, structured(self.spec.center, p))))
        s = dot(around, around) * p[7]
        fading = 2.0 * p[6] * p[7] * mean_decay_slope(s)
        return ti.static(_gradient(axis, around, p[6] * mean_decay(s), fading))


def _gradient(axis, around, spin, fading):
    """∂u/∂x of u = spin(|n × d|²) n × d, `fading` being twice the derivative of spin."""
    outward = scaled(-1.0, cross(axis, around))
    return total([times(spin, turning(axis)), outer(scaled(fading, around), outward)])

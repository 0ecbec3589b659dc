"""A force about a point that rides on a coordinate frame."""

import taichi as ti

from particlecli.dynamics.forces.base import ForceTerm
from particlecli.dynamics.matrices import product
from particlecli.dynamics.riding import applied, plus, pose, transposed
from particlecli.dynamics.vectors import structured
from particlecli.scene.forces import PlacedForce
from particlecli.scene.frames import Chain


class Riding(ForceTerm[PlacedForce]):
    """a = R b(c + Rᵀ (x − T − s R c)), with b the acceleration by the force where the frame is the world.

    Symbols: c the force's center, m; T + s R x the pose of the frame, see `scene.poses`. Only forces that do
    not depend on the velocity ride on frames.

    Args:
        term: the force.
        ride: the frames from the world to the one it rides on.
    """

    def __init__(self, term: ForceTerm[PlacedForce], ride: Chain) -> None:
        super().__init__(term.spec)
        self.term = term
        self.ride = ride
        self.has_potential = term.has_potential

    def parameters(self) -> list[float]:
        """Those of the force."""
        return self.term.parameters()

    def _seen(self, p, x, t):
        """The rotation of the frame, and the position as the force sees it."""
        here, center = pose(self.ride, t), structured(self.spec.center, p)
        there = here._replace(shift=here.point(center))
        return here.rotation, plus(center, there.unturned(x))

    @ti.func
    def acceleration(self, p, x, v, u, t, inverse_mass):
        """The acceleration, m/s²."""
        rotation, seen = ti.static(self._seen(p, x, t))
        own = self.term.acceleration(p, seen, v, u, t, inverse_mass)
        return ti.static(applied(rotation, own))

    @ti.func
    def jacobian(self, p, x, v, u, gradient, t, inverse_mass):
        """The derivatives by position, 1/s², and velocity, 1/s."""
        rotation, seen = ti.static(self._seen(p, x, t))
        by_position, by_velocity = self.term.jacobian(p, seen, v, u, gradient, t, inverse_mass)
        return ti.static(product(product(rotation, by_position), transposed(rotation))), by_velocity

    @ti.func
    def potential(self, p, x, t, inverse_mass):
        """The potential energy by mass, J/kg."""
        _, seen = ti.static(self._seen(p, x, t))
        return self.term.potential(p, seen, t, inverse_mass)

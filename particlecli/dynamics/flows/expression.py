"""A velocity field written out in the scene."""

from functools import cached_property

import taichi as ti

from particlecli.dynamics.expressions import derivatives, evaluate, evaluate_all
from particlecli.dynamics.flows.base import FlowTerm
from particlecli.scene import flows as scene


class Written(FlowTerm[scene.ExpressionFlow]):
    """u = (f(x, y, z, t), g(x, y, z, t), h(x, y, z, t)).

    Symbols: f, g, h the scene's expressions, m/s, of the position x, y, z, m, and the time t, s.
    """

    @cached_property
    def _slopes(self):
        return derivatives(self.spec.velocity, "xyz")

    def _components(self, x, t):
        return tuple(evaluate(component, _names(x, t)) for component in self.spec.velocity)

    def _derivatives(self, x, t):
        return evaluate_all(self._slopes, _names(x, t))

    @ti.func
    def velocity(self, p, x, t):
        """The velocity, m/s."""
        return ti.static(self._components(x, t))

    @ti.func
    def gradient(self, p, x, t):
        """The derivatives by position, 1/s."""
        return ti.static(self._derivatives(x, t))


def _names(x, t):
    return {"x": x[0], "y": x[1], "z": x[2], "t": t}

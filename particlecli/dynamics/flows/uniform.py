"""The same velocity everywhere."""

import taichi as ti

from particlecli.dynamics.flows.base import FlowTerm
from particlecli.dynamics.matrices import ZERO
from particlecli.dynamics.vectors import structured
from particlecli.scene import flows as scene


class Uniform(FlowTerm[scene.UniformFlow]):
    """u = w.

    Symbols: w velocity, m/s.
    """

    def parameters(self) -> list[float]:
        """The velocity w."""
        return list(self.spec.velocity)

    @ti.func
    def velocity(self, p, x, t):
        """The velocity, m/s."""
        return ti.static(structured(self.spec.velocity, p))

    @ti.func
    def gradient(self, p, x, t):
        """The derivatives by position, 1/s: none."""
        return ZERO

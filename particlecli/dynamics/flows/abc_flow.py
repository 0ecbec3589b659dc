"""The steady flow in which most tracers wander chaotically."""

import taichi as ti

from particlecli.dynamics.algebra import add, mul
from particlecli.dynamics.flows.base import FlowTerm
from particlecli.dynamics.vector_math import cos, sin
from particlecli.dynamics.vectors import structured
from particlecli.scene import flows as scene


class AbcFlow(FlowTerm[scene.AbcFlow]):
    """u = (A sin kz + C cos ky, B sin kx + A cos kz, C sin ky + B cos kx).

    Symbols: A, B, C amplitudes, m/s; k wave number, rad/m. An exact steady solution of Euler's equations:
    its vorticity is k u everywhere, its divergence zero.
    Source: Arnold (1965), Beltrami, Childress (1970); Dombre et al., J. Fluid Mech. 167 (1986) 353.
    """

    def parameters(self) -> list[float]:
        """Amplitudes A, B, C, and the wave number."""
        return [*self.spec.amplitudes, self.spec.wave_number]

    def _velocity(self, p, sines, cosines):
        a, b, c = structured(self.spec.amplitudes, p)
        return (
            add(mul(a, sines[2]), mul(c, cosines[1])),
            add(mul(b, sines[0]), mul(a, cosines[2])),
            add(mul(c, sines[1]), mul(b, cosines[0])),
        )

    def _gradient(self, p, sines, cosines):
        a, b, c = (mul(p[3], amplitude) for amplitude in structured(self.spec.amplitudes, p))
        return (
            (0.0, mul(-1.0, mul(c, sines[1])), mul(a, cosines[2])),
            (mul(b, cosines[0]), 0.0, mul(-1.0, mul(a, sines[2]))),
            (mul(-1.0, mul(b, sines[0])), mul(c, cosines[1]), 0.0),
        )

    @ti.func
    def velocity(self, p, x, t):
        """The velocity, m/s."""
        sines = [sin(p[3] * x[i]) for i in ti.static(range(3))]
        cosines = [cos(p[3] * x[i]) for i in ti.static(range(3))]
        return ti.static(self._velocity(p, sines, cosines))

    @ti.func
    def gradient(self, p, x, t):
        """The derivatives by position, 1/s."""
        sines = [sin(p[3] * x[i]) for i in ti.static(range(3))]
        cosines = [cos(p[3] * x[i]) for i in ti.static(range(3))]
        return ti.static(self._gradient(p, sines, cosines))

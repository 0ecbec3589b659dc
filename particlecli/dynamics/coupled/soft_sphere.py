"""Soft spheres: grains that push each other away and lose energy in collisions."""

from collections.abc import Sequence

import taichi as ti

from particlecli.dynamics.coupled.local import LocalTerm
from particlecli.dynamics.coupled.points import Points
from particlecli.scene import forces as scene


class SoftSphere(LocalTerm[scene.SoftSphere]):
    """F = N n, N = max(0, k (D − r) − γ v_n) where r < D.

    Symbols: r distance of a pair, m; n direction from the other; D diameter, m; k stiffness, N/m; γ damping, kg/s;
    v relative velocity, v_n = v·n, m/s. Spheres with friction are `RoughSphere`s.
    Spheres at the same place do not act on each other: the force has no direction there.
    Without γ, U = Σ_pairs ½ k (D − r)².
    Source: Cundall & Strack, Géotechnique 29 (1979) 47.
    """

    def __init__(self, spec: scene.SoftSphere, points: Points, groups: Sequence[int]) -> None:
        super().__init__(spec, points, groups, spec.diameter, moves=spec.depends_on_velocity)
        self.has_potential = not spec.depends_on_velocity

    def parameters(self) -> list[float]:
        """D², D, k, γ."""
        spec = self.spec
        return [spec.diameter**2, spec.diameter, spec.stiffness, spec.damping]

    @ti.func
    def force(self, p, d, distance2, here, there):
        """The force by one neighbour, N."""
        touches = (distance2 < p[0]) & (distance2 > 0.0)
        inverse = 1.0 / ti.sqrt(ti.select(touches, distance2, p[0]))
        n = [inverse * d[c] for c in ti.static(range(3))]
        pressing = ti.select(touches, p[2] * (p[1] - distance2 * inverse), 0.0)
        if ti.static(self.depends_on_velocity):
            v = [here[4 + c] - there[4 + c] for c in ti.static(range(3))]
            apart = n[0] * v[0] + n[1] * v[1] + n[2] * v[2]
            pressing = ti.select(touches, ti.max(pressing - p[3] * apart, 0.0), 0.0)
        return [pressing * n[0], pressing * n[1], pressing * n[2], 0.0]

    @ti.func
    def energy(self, p, d, distance2, here, there):
        """The energy of a pair, J."""
        overlap = ti.max(p[1] - ti.sqrt(distance2), 0.0)
        return [0.5 * p[2] * overlap * overlap, 0.0, 0.0, 0.0]

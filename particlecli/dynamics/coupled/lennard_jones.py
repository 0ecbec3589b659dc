"""The Lennard-Jones force between atoms."""

from collections.abc import Sequence

import taichi as ti

from particlecli.dynamics.coupled.images import periodic_maps
from particlecli.dynamics.coupled.local import LocalTerm
from particlecli.dynamics.coupled.neighbors import Periodic
from particlecli.dynamics.coupled.points import Points
from particlecli.scene import forces as scene


class LennardJones(LocalTerm[scene.LennardJones]):
    """U = Σ_pairs φ(r) − φ(r_c) where r < r_c, φ = 4ε [(σ/r)¹² − (σ/r)⁶], F = −∇U.

    Symbols: r distance of a pair, m; ε depth of the well, J; σ distance where φ = 0, m; r_c cutoff, m.
    Shifted by the force too, the potential has −(r² − r_c²) φ′(r_c)/(2 r_c) besides, so that the force ends at zero.
    Two atoms at the same place repel each other without bound: not finite.
    Source: Lennard-Jones, Proc. Phys. Soc. 43 (1931) 461; Stoddard & Ford, Phys. Rev. A 8 (1973) 1504.
    """

    has_potential = True

    def __init__(self, spec: scene.LennardJones, points: Points, groups: Sequence[int]) -> None:
        box = spec.periodic
        size = (0.0, 0.0, 0.0) if box is None else box.size
        super().__init__(
            spec,
            points,
            groups,
            spec.reach,
            periodic=None if box is None else Periodic(box.min, size),
            maps=periodic_maps(size),
        )

    def parameters(self) -> list[float]:
        """r_c², 48 ε σ¹², 24 ε σ⁶, φ(r_c), φ′(r_c)/r_c."""
        energy, size6, inverse6, reach2 = self.spec.energy, self.spec.size**6, self.spec.reach**-6, self.spec.reach**2
        repulsion, attraction = 48.0 * energy * size6 * size6, 24.0 * energy * size6
        last = inverse6 * (repulsion * inverse6 / 12.0 - attraction / 6.0)
        return [reach2, repulsion, attraction, last, -inverse6 * (repulsion * inverse6 - attraction) / reach2]

    @ti.func
    def force(self, p, d, distance2, here, there):
        """The force by one neighbour, N."""
        inverse2 = 1.0 / distance2
        inverse6 = inverse2 * inverse2 * inverse2
        factor = inverse2 * inverse6 * (p[1] * inverse6 - p[2])
        if ti.static(self.spec.shifted == "force"):
            factor = factor + p[4]
        factor = ti.select(distance2 < p[0], factor, 0.0)
        return [factor * d[0], factor * d[1], factor * d[2], 0.0]

    @ti.func
    def energy(self, p, d, distance2, here, there):
        """The energy of a pair, J."""
        inverse2 = 1.0 / distance2
        inverse6 = inverse2 * inverse2 * inverse2
        value = inverse6 * (p[1] * inverse6 / 12.0 - p[2] / 6.0) - p[3]
        if ti.static(self.spec.shifted == "force"):
            value = value - 0.5 * p[4] * (distance2 - p[0])
        return [ti.select(distance2 < p[0], value, 0.0), 0.0, 0.0, 0.0]

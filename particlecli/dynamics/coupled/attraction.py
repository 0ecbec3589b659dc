"""Attraction between every two particles, summed up directly."""

import taichi as ti

from particlecli.dynamics.coupled.base import CoupledTerm
from particlecli.dynamics.group_plan import LANES
from particlecli.scene import forces as scene


class Attraction(CoupledTerm[scene.Attraction]):
    """a_i = G Σ_j m_j d_ij / (|d_ij|² + ε²)^(3/2), U = −½ G Σ_i Σ_j m_i m_j / (|d_ij|² + ε²)^(1/2), d_ij = x_j − x_i.

    Symbols: G gravitational constant, m³/(kg s²) (negative: particles repel); m masses, kg; ε softening, m.
    Particles at the same place do not act on each other: the force has no direction there.
    Source: Newton, "Principia" (1687), book I, prop. LXIX; softening after Plummer, MNRAS 71 (1911) 460.
    """

    has_potential = True

    def parameters(self) -> list[float]:
        """G, ε²."""
        return [self.spec.strength, self.spec.softening**2]

    @ti.func
    def acceleration(self, p, b, t):
        """Three packs, m/s²."""
        x, y, z = self.points.state[0, b], self.points.state[1, b], self.points.state[2, b]
        ax, ay, az = 0.0 * x, 0.0 * x, 0.0 * x
        for g in ti.static(self.groups):
            first = self.points.firsts[g] * LANES
            for j in range(first, first + self.points.counts[g]):
                k, lane = j // LANES, j % LANES
                dx = self.points.state[0, k][lane] - x
                dy = self.points.state[1, k][lane] - y
                dz = self.points.state[2, k][lane] - z
                factor = self.points.mass[k][lane] * self._inverse(p, dx * dx + dy * dy + dz * dz, 3)
                ax += factor * dx
                ay += factor * dy
                az += factor * dz
        return [p[0] * ax, p[0] * ay, p[0] * az]

    @ti.func
    def _inverse(self, p, distance2, power: ti.template()):
        """The softened distance to the power −1 or −3; zero where two particles are at the same place."""
        if ti.static(self.spec.softening > 0):
            return 1.0 / _power(distance2 + p[1], power)
        return ti.select(distance2 > 0.0, 1.0 / _power(distance2, power), 0.0)

    @ti.func
    def potential(self, p, b, t):
        """Of the particles of a pack, J."""
        x, y, z = self.points.state[0, b], self.points.state[1, b], self.points.state[2, b]
        total = 0.0 * x
        for g in ti.static(self.groups):
            first = self.points.firsts[g] * LANES
            for j in range(first, first + self.points.counts[g]):
                k, lane = j // LANES, j % LANES
                dx = self.points.state[0, k][lane] - x
                dy = self.points.state[1, k][lane] - y
                dz = self.points.state[2, k][lane] - z
                inverse = self._inverse(p, dx * dx + dy * dy + dz * dz, 1)
                total += ti.select(
                    ti.Vector(list(range(LANES))) + b * LANES == j, 0.0, self.points.mass[k][lane] * inverse
                )
        return -0.5 * p[0] * self.points.mass[b] * total


@ti.func
def _power(distance2, power: ti.template()):
    """A distance to the power 1 or 3."""
    if ti.static(power == 1):
        return ti.sqrt(distance2)
    return distance2 * ti.sqrt(distance2)

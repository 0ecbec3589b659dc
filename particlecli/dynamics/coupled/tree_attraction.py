"""Attraction between every two particles, far ones taken together in the cells of an octree."""

from collections.abc import Sequence

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.base import CoupledTerm
from particlecli.dynamics.coupled.octree import Octree
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.coupled.sharing import SHARE
from particlecli.dynamics.group_plan import LANES
from particlecli.scene import forces as scene


class TreeAttraction(CoupledTerm[scene.Attraction]):
    """As `Attraction`, with a_i = G [M d/R³ − 3 S d/R⁵ + (15/2 dᵀS d/R² − 3/2 tr S) d/R⁵] for a cell as a whole.

    Symbols: M mass of the cell, kg; d offset to its centre of mass, m; R² = |d|² + ε²; S = Σ m δ δᵀ about it, kg m².
    A pack of particles that stand together walks the tree as one. A cell acts as a whole where its side, seen at its
    centre of mass from the nearest place in the pack's box, spans less than the opening angle; else its children do,
    or its bodies one by one. Reactions do not exactly equal actions, so momentum is kept to the error of the forces.
    Source: Barnes & Hut, Nature 324 (1986) 446; Barnes, "A modified tree code", J. Comput. Phys. 87 (1990) 161.
    """

    needs_preparation = True
    has_potential = True

    def __init__(self, spec: scene.Attraction, points: Points, groups: Sequence[int]) -> None:
        super().__init__(spec, points, groups)
        self.tree = Octree(points, self.groups, spec.opening_angle)
        pack = ti.types.vector(LANES, points.real)
        self.accelerations = ti.field(pack, shape=(3, points.capacity))
        self.potentials = ti.field(pack, shape=points.capacity)
        self.table = points.memory.table(points.real, np.array([spec.strength, spec.softening**2]))

    def prepare(self, time: float) -> None:
        """Build the tree, and walk it for all."""
        self.tree.build()
        if self.tree.count:
            self._walk(self.tree.cells, self.tree.cell_count, self.tree.count, False)

    def prepare_potential(self, time: float) -> None:
        """The same for energies."""
        self.tree.build()
        if self.tree.count:
            self._walk(self.tree.cells, self.tree.cell_count, self.tree.count, True)

    @ti.func
    def acceleration(self, p, b, t):
        """Three packs, m/s²."""
        return [self.accelerations[c, b] for c in ti.static(range(3))]

    @ti.func
    def potential(self, p, b, t):
        """Of the particles of a pack, J."""
        return 0.5 * self.points.mass[b] * self.potentials[b]

    @ti.kernel
    def _walk(self, cells: ti.template(), cell_count: ti.i32, count: ti.i32, energy: ti.template()):
        width = ti.static(self.tree.width)
        ti.loop_config(block_dim=SHARE)
        for b in range((count + width - 1) // width):
            x = [
                ti.Vector([self.tree.bodies[ti.min(b * width + k, count - 1)][c] for k in range(width)])
                for c in ti.static(range(3))
            ]
            s = self._summed(cells, cell_count, x, energy)
            for k in range(ti.min(width, count - b * width)):
                slot = self.tree.order[b * width + k]
                if ti.static(energy):
                    self.potentials[slot // LANES][slot % LANES] = -self.table[0] * s[0][k]
                else:
                    for c in ti.static(range(3)):
                        self.accelerations[c, slot // LANES][slot % LANES] = self.table[0] * s[c][k]

    @ti.func
    def _summed(self, cells: ti.template(), cell_count, x, energy: ti.template()):
        """Sums over all bodies for a pack at x: three packs by G of acceleration, or the first by −G of potential."""
        s0, s1, s2 = 0.0 * x[0], 0.0 * x[0], 0.0 * x[0]
        low = [x[c].min() for c in ti.static(range(3))]
        high = [x[c].max() for c in ti.static(range(3))]
        n = 0
        while n < cell_count:
            span, center = cells.span[n], cells.center[n]
            distance2 = ti.cast(0.0, cells.real)
            for c in ti.static(range(3)):
                gap = ti.max(low[c] - center[c], center[c] - high[c], 0.0)
                distance2 += gap * gap
            if distance2 > cells.reach2[n]:
                d = [center[c] - x[c] for c in ti.static(range(3))]
                q = self._of_cell(center[3], cells.spread[n], d, energy)
                s0, s1, s2 = s0 + q[0], s1 + q[1], s2 + q[2]
                n = span[2]
            elif span[3] == 1:
                for j in range(span[0], span[1]):
                    body = self.tree.bodies[j]
                    d = [body[c] - x[c] for c in ti.static(range(3))]
                    q = self._of_body(body[3], d, energy)
                    s0, s1, s2 = s0 + q[0], s1 + q[1], s2 + q[2]
                n = span[2]
            else:
                n += 1
        return [s0, s1, s2]

    @ti.func
    def _of_body(self, mass, d, energy: ti.template()):
        distance2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
        softened2 = distance2 + self.table[1]
        # A body is left out of the sum for itself; others at its place have no direction, but energy if softened.
        inverse2 = ti.select(distance2 > 0.0, 1.0 / softened2, 0.0)
        inverse = ti.sqrt(inverse2)
        if ti.static(energy):
            return [mass * inverse, 0.0 * d[0], 0.0 * d[0]]
        factor = mass * inverse * inverse2
        return [factor * d[0], factor * d[1], factor * d[2]]

    @ti.func
    def _of_cell(self, mass, spread, d, energy: ti.template()):
        inverse2 = 1.0 / (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + self.table[1])
        inverse = ti.sqrt(inverse2)
        sx = spread[0] * d[0] + spread[1] * d[1] + spread[2] * d[2]
        sy = spread[1] * d[0] + spread[3] * d[1] + spread[4] * d[2]
        sz = spread[2] * d[0] + spread[4] * d[1] + spread[5] * d[2]
        square = (d[0] * sx + d[1] * sy + d[2] * sz) * inverse2
        trace = spread[0] + spread[3] + spread[5]
        inverse3 = inverse * inverse2
        if ti.static(energy):
            return [mass * inverse + (1.5 * square - 0.5 * trace) * inverse3, 0.0 * d[0], 0.0 * d[0]]
        inverse5 = inverse3 * inverse2
        factor = mass * inverse3 + (7.5 * square - 1.5 * trace) * inverse5
        turned = -3.0 * inverse5
        return [factor * d[0] + turned * sx, factor * d[1] + turned * sy, factor * d[2] + turned * sz]

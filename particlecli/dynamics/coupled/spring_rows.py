"""Where particles that springs act on stand: packs of their groups as rows, one after the other."""

from collections.abc import Sequence

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.bodies import Graph
from particlecli.dynamics.coupled.pins import Pins
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.coupled.springs import Springs
from particlecli.dynamics.group_plan import LANES


@ti.data_oriented
class SpringRows:
    """The rows. A particle's place is 16 row + lane.

    Args:
        springs: the forces.
        points: all particles.

    Attributes:
        count: rows.
    """

    def __init__(self, springs: Sequence[Springs], points: Points) -> None:
        self.springs, self.points = list(springs), points
        self.groups = sorted({g for each in springs for g in each.groups})
        rows = [-(-self.points.capacities[g] // LANES) for g in self.groups]
        self.firsts = np.cumsum([0, *rows]).tolist()
        self.count = self.firsts[-1]

    def graph(self) -> tuple[Graph, list]:  # type: ignore[type-arg]
        """The graph of the springs, by places; and by force the entries of its springs, as of `Springs.ends`."""
        pairs, weights, entries = [np.empty((0, 2), np.int64)], [np.empty(0)], []
        for each in self.springs:
            joined, found = each.ends()
            firsts = [self.firsts[self.groups.index(g)] * LANES for g in each.groups]
            pairs += [ends + first for ends, first in zip(joined, firsts, strict=True)]
            entries.append(np.concatenate(found))
            weights.append(np.full(len(entries[-1]), each.spec.stiffness))
        return Graph(self.count * LANES, np.concatenate(pairs), np.concatenate(weights)), entries

    def positions(self):
        """Where particles are at first, m, shape (16 rows, 3); zero in lanes without one."""
        found = np.zeros((self.count * LANES, 3))
        for each in self.springs:
            for g, positions in zip(each.groups, each.positions, strict=True):
                first = self.firsts[self.groups.index(g)] * LANES
                found[first : first + positions.shape[1]] = positions.T
        return found

    def free(self, pins: Pins):
        """Which places move, shape (16 rows)."""
        free = np.ones(self.count * LANES, bool)
        for row, g in zip(self.firsts, self.groups, strict=False):
            pinned = pins.pinned(g)
            free[row * LANES : row * LANES + len(pinned)] = ~pinned
        return free

    @ti.func
    def pack(self, row):
        """The pack of points in a row."""
        b = row
        for i in ti.static(range(len(self.groups))):
            if row >= self.firsts[i]:
                b = self.points.firsts[self.groups[i]] + row - self.firsts[i]
        return b

    @ti.func
    def row(self, b):
        """The row of a pack of points, −1 where no spring can be."""
        row = -1
        for i in ti.static(range(len(self.groups))):
            if self.points.holds(self.groups[i], b):
                row = self.firsts[i] + b - self.points.firsts[self.groups[i]]
        return row

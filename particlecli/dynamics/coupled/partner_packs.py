"""What the particles of a pack get from their partners: whole parts of packs where partners stand alike."""

from collections.abc import Sequence

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.links import APART
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.group_plan import LANES

MOST_TURNS = 6
"""So many ways to put partners together from two packs are compiled at most, the most frequent ones."""


@ti.data_oriented
class PartnerPacks:
    """For each slot of a table of partners where they stand.

    Partners that stand equally far ahead are parts of two packs, which is far less to load than lane by lane.

    Args:
        steps: as of `Adjacency`, by slot.
        partners: field of packs of i32: the numbers of the partners in their group, by slot.
        points: all particles.
        groups: those that the table is of.
    """

    def __init__(self, steps, partners, points: Points, groups: Sequence[int]) -> None:
        self.partners, self.points, self.groups = partners, points, tuple(groups)
        ways = np.stack([steps // LANES, np.where(steps == APART, -1, steps % LANES)], axis=1)
        turns, often = np.unique(ways[:, 1], return_counts=True)
        self.turns = [int(turn) for turn in turns[np.argsort(-often)] if turn > 0][:MOST_TURNS]
        ways[~np.isin(ways[:, 1], [0, *self.turns])] = 0, -1
        self.ways = points.memory.table(ti.i32, ways if len(ways) else np.zeros((1, 2), np.int32))

    @ti.func
    def vectors(self, field: ti.template(), row: ti.template(), slot, b, first):
        """Vectors of the partners in a slot, three packs of a field; of lanes without a partner those of any particle.

        Args:
            field: of packs, shape (rows, packs).
            row: where vectors begin, of three rows.
            slot: in the table, of pack b.
            first: the first pack of the group.
        """
        last, turn = self._last(b), self.ways[slot, 1]
        near = ti.min(ti.max(b + self.ways[slot, 0], first), last)
        x, y, z = field[row, near], field[row + 1, near], field[row + 2, near]
        for w in ti.static(self.turns):
            if turn == w:
                far = ti.min(ti.max(b + self.ways[slot, 0] + 1, first), last)
                x = _turned(x, field[row, far], w)
                y = _turned(y, field[row + 1, far], w)
                z = _turned(z, field[row + 2, far], w)
        if turn < 0:
            x = self.points.gathered_from(field, row, self.partners[slot], first)
            y = self.points.gathered_from(field, row + 1, self.partners[slot], first)
            z = self.points.gathered_from(field, row + 2, self.partners[slot], first)
        return x, y, z

    @ti.func
    def _last(self, b):
        """The last pack of the group of pack b."""
        last = b
        for g in ti.static(self.groups):
            if self.points.holds(g, b):
                last = self.points.firsts[g + 1] - 1
        return last


@ti.func
def _turned(near, far, turn: ti.template()):
    """Lanes `turn` to 15 of a pack, then those before `turn` of another."""
    kept = [near[lane] for lane in ti.static(range(turn, LANES))]
    return ti.Vector(kept + [far[lane] for lane in ti.static(range(turn))])

"""A coarse correction of implicit steps: particles that springs join move together, as rigid bodies.

Stiff springs let their ends turn around each other, so what is hard to find by steps from spring to spring is how whole
parts turn against each other. Bodies that move and turn represent that (rigid body modes of aggregates: Bulgakov &
Kuhn, Int. J. Numer. Meth. Eng. 38 (1995) 3529; Vaněk, Mandel & Brezina, Computing 56 (1996) 179). Their equations are
solved directly, and what they find is added to what the particles' own blocks make of the residual: so the matrix of
the particles, where all the bytes are, is multiplied by once an iteration of conjugate gradients.
"""

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.block_factor import BlockFactor
from particlecli.dynamics.coupled.bodies import bodies
from particlecli.dynamics.coupled.body_equations import BodyEquations
from particlecli.dynamics.coupled.pins import Pins
from particlecli.dynamics.coupled.sharing import SHARE
from particlecli.dynamics.coupled.spring_rows import SpringRows
from particlecli.dynamics.group_plan import LANES


@ti.data_oriented
class RigidBodies:
    """The bodies, and what they make of what is left of Newton's equations.

    Args:
        rows: the particles.
        pins: those that do not move.
        alone: as of `BodyEquations`.

    Attributes:
        count: how many bodies; with none there is nothing else.
        rest: field of packs, shape (3, rows): what is left.
    """

    def __init__(self, rows: SpringRows, pins: Pins, alone) -> None:
        self.rows = rows
        owners, elimination = bodies(rows.graph()[0], rows.positions(), rows.free(pins))
        self.count = elimination.count
        if self.count:
            self.factor = BlockFactor(elimination, rows.points)
            self.equations = BodyEquations(rows, alone, owners, elimination.numbers())
            self.rest = ti.field(ti.types.vector(LANES, rows.points.real), shape=(3, rows.count))
            self.owners = ti.field(ti.types.vector(LANES, ti.i32), shape=rows.count)
            rows.points.memory.view(self.owners, np.where(owners >= 0, owners, self.count).reshape(-1, LANES))

    @ti.kernel
    def refresh(self):
        """Put the equations of the bodies together and factorize them, for particles and springs as they are now."""
        for body in range(self.count):
            self.equations.center(body)
        for j in ti.static(range(len(self.rows.springs))):
            for e in range(self.equations.links[j], self.equations.links[j + 1]):
                self.equations.load(j, e)
        ti.loop_config(block_dim=SHARE)
        for block in range(self.count + self.factor.blocks):
            self.equations.assemble(self.factor.values, block)
        ti.loop_config(block_dim=1)
        for branch in range(self.factor.branches):
            for k in range(self.factor.firsts[branch], self.factor.firsts[branch + 1]):
                self.factor.eliminate(k)
        ti.loop_config(serialize=True)
        for k in range(self.factor.trunk, self.count):
            self.factor.eliminate(k)

    @ti.func
    def begin(self, branch):
        """Solve for the bodies of a branch with those before them, from `rest`."""
        for k in range(self.factor.firsts[branch], self.factor.firsts[branch + 1]):
            self.factor.descend(k, self._gathered(k))

    @ti.func
    def turn(self):
        """Solve for the bodies of the trunk, once all branches have begun.

        Returns: what was found for all of them, times what was left.
        """
        for k in range(self.factor.trunk, self.count):
            self.factor.descend(k, self._gathered(k))
        for k in range(self.count - self.factor.trunk):
            self.factor.ascend(self.count - 1 - k)
        return self.factor.product()

    @ti.func
    def end(self, branch):
        """Solve for the bodies of a branch."""
        first, last = self.factor.firsts[branch], self.factor.firsts[branch + 1]
        for k in range(last - first):
            self.factor.ascend(last - 1 - k)

    @ti.func
    def _gathered(self, body):
        """The force and the torque that are left on a body."""
        found = 0.0 * self.factor.halfway[body]
        for m in range(self.equations.member_starts[body], self.equations.member_starts[body + 1]):
            row, lane = self.equations.members[m] >> 4, self.equations.members[m] & 15
            fx, fy, fz = [ti.cast(self.rest[c, row][lane], ti.f64) for c in ti.static(range(3))]
            x, y, z = [ti.cast(self.equations.arms[c, row][lane], ti.f64) for c in ti.static(range(3))]
            found += ti.Vector([fx, fy, fz, y * fz - z * fy, z * fx - x * fz, x * fy - y * fx, 0.0, 0.0])
        return found

    @ti.func
    def moved(self, row):
        """What the particles of a row get from their bodies, three packs."""
        x, y, z = self.equations.arms[0, row], self.equations.arms[1, row], self.equations.arms[2, row]
        u, v, w, p, q, r = x, x, x, x, x, x
        for lane in range(LANES):
            body = self.owners[row][lane]
            u[lane], v[lane], w[lane] = [
                ti.cast(self.factor.solution[body][c], self.rows.points.real) for c in ti.static(range(3))
            ]
            p[lane], q[lane], r[lane] = [
                ti.cast(self.factor.solution[body][c], self.rows.points.real) for c in ti.static(range(3, 6))
            ]
        return [u + q * z - r * y, v + r * x - p * z, w + p * y - q * x]

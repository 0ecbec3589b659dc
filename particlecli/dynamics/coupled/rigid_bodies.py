"""A coarse correction of implicit steps: particles that springs join move together, as rigid bodies.

Stiff springs let their ends turn around each other, so what is hard to find by steps from spring to spring is how whole
parts turn against each other. Bodies that move and turn represent that (rigid body modes of aggregates: Bulgakov &
Kuhn, Int. J. Numer. Meth. Eng. 38 (1995) 3529; Vaněk, Mandel & Brezina, Computing 56 (1996) 179). Their equations are
solved directly, and what they find is added to what the particles' own blocks make of the residual: so the matrix of
the particles, where all the bytes are, is multiplied by once an iteration of conjugate gradients.
"""

import taichi as ti

from particlecli.dynamics.coupled.block_factor import BlockFactor
from particlecli.dynamics.coupled.blocks import total
from particlecli.dynamics.coupled.bodies import bodies
from particlecli.dynamics.coupled.body_equations import BodyEquations
from particlecli.dynamics.coupled.pins import Pins
from particlecli.dynamics.coupled.spring_rows import SpringRows
from particlecli.dynamics.coupled.team import Team
from particlecli.dynamics.group_plan import LANES


@ti.data_oriented
class RigidBodies:
    """The bodies, and what they make of what is left of Newton's equations.

    Args:
        rows: the particles.
        pins: those that do not move.
        alone: as of `BodyEquations`.
        residual: field of packs, shape (3, packs): what is left of the equations, zero for what does not move.
        team: whose members carry it all out.

    Attributes:
        count: how many bodies; with none there is nothing else.
    """

    def __init__(self, rows: SpringRows, pins: Pins, alone, residual, team: Team) -> None:
        self.rows, self.residual, self.team = rows, residual, team
        owners, elimination = bodies(rows.graph()[0], rows.positions(), rows.free(pins))
        self.count = elimination.count
        if self.count:
            self.factor = BlockFactor(elimination, rows.points)
            self.equations = BodyEquations(rows, alone, owners, elimination.numbers())

    @ti.func
    def refresh(self, member, members):
        """Put the equations of the bodies together and factorize them, for particles and springs as they are."""
        if ti.static(self.count > 0):
            self._assemble(member, members)
            self.team.meet(members)
            branch = member
            while branch < self.factor.branches:
                for k in range(self.factor.firsts[branch], self.factor.firsts[branch + 1]):
                    self.factor.eliminate(k)
                branch += members
            self.team.meet(members)
            if member == 0:
                for k in range(self.factor.trunk, self.count):
                    self.factor.eliminate(k)

    @ti.func
    def _assemble(self, member, members):
        first, last = self.team.share(member, members, self.count)
        for body in range(first, last):
            self.equations.center(body)
        self.team.meet(members)
        first, last = self.team.share(member, members, self.rows.count)
        for row in range(first, last):
            self.equations.reach(row)
        self.team.meet(members)
        block = member
        while block < self.count + self.factor.blocks:
            self.equations.assemble(self.factor.values, block)
            block += members

    @ti.func
    def solve(self, member, members):
        """Find how bodies move, from the residual, which all have seen; returns that times what was left."""
        first, last = self.team.share(member, members, self.count)
        for k in range(first, last):
            self.factor.halfway[k] = self._gathered(k)
        self.team.meet(members)
        branch = member
        while branch < self.factor.branches:
            for k in range(self.factor.firsts[branch], self.factor.firsts[branch + 1]):
                self.factor.descend(k)
            branch += members
        self.team.meet(members)
        if member == 0:
            for k in range(self.factor.trunk, self.count):
                self.factor.descend(k)
            for k in range(self.count - self.factor.trunk):
                self.factor.ascend(self.count - 1 - k)
        self.team.meet(members)
        branch = member
        while branch < self.factor.branches:
            begin, end = self.factor.firsts[branch], self.factor.firsts[branch + 1]
            for k in range(end - begin):
                self.factor.ascend(end - 1 - k)
            branch += members
        self.team.meet(members)
        return self.factor.product()

    @ti.func
    def _gathered(self, body):
        """The force and the torque that are left on a body: in double precision, as it is solved for.

        A straight hair hardly feels a turn about itself, and what rounding made of its torque would count as much.
        """
        zero = ti.Vector.zero(ti.f64, LANES)
        fx, fy, fz, p, q, r = zero, zero, zero, zero, zero, zero
        for s in range(self.equations.row_starts[body], self.equations.row_starts[body + 1]):
            row = self.equations.body_rows[s]
            b, own = self.rows.pack(row), self.equations.owners[row] == body
            u, v, w = [ti.cast(ti.select(own, self.residual[c, b], 0.0), ti.f64) for c in ti.static(range(3))]
            x, y, z = [ti.cast(self.equations.arms[c, row], ti.f64) for c in ti.static(range(3))]
            fx, fy, fz = fx + u, fy + v, fz + w
            p, q, r = p + (y * w - z * v), q + (z * u - x * w), r + (x * v - y * u)
        for c in ti.static(range(6)):
            self.equations.sums[c, body] = [fx, fy, fz, p, q, r][c]
        found = 0.0 * self.factor.halfway[body]
        for c in ti.static(range(6)):
            found[c] = total(self.equations.sums, c, body)
        return found

    @ti.func
    def moved(self, row):
        """What the particles of a row get from their bodies, three packs."""
        x, y, z = self.equations.arms[0, row], self.equations.arms[1, row], self.equations.arms[2, row]
        mx, my, mz = 0.0 * x, 0.0 * x, 0.0 * x
        for s in range(self.equations.body_starts[row], self.equations.body_starts[row + 1]):
            body = self.equations.row_bodies[s]
            own = self.equations.owners[row] == body
            m = ti.cast(self.factor.solution[body], self.rows.points.real)
            mx = ti.select(own, m[0] + m[4] * z - m[5] * y, mx)
            my = ti.select(own, m[1] + m[5] * x - m[3] * z, my)
            mz = ti.select(own, m[2] + m[3] * y - m[4] * x, mz)
        return [mx, my, mz]

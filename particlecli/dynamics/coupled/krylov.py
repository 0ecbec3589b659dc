"""Newton's equations, solved by preconditioned conjugate gradients."""

import math

import taichi as ti

from particlecli.dynamics.coupled.blocks import product
from particlecli.dynamics.coupled.implicit_stages import ImplicitStages
from particlecli.dynamics.coupled.newton_equations import NewtonEquations
from particlecli.dynamics.coupled.rigid_bodies import RigidBodies
from particlecli.dynamics.coupled.sharing import SHARE
from particlecli.dynamics.coupled.spring_rows import SpringRows
from particlecli.dynamics.coupled.springs import Springs
from particlecli.dynamics.coupled.step import Step
from particlecli.dynamics.coupled.team import MOST, Team
from particlecli.dynamics.group_plan import LANES

RESIDUAL, FOUND, STATE, SIZE, ROUNDING = range(5)
"""Places in the numbers: r·z; δ·Aδ of the change found; how far an iteration of Newton's method is; if something was
changed Σ m |k|²; what rounding of positions is worth as δ·Aδ, times h⁴ a⁴."""

GOING, CHANGED, KEPT, LOST = range(4)
"""Conjugate gradients have not ended yet; the accelerations are changed; they were good enough; there are none that are
numbers, or the matrix is not positive definite."""

MANY = 4096
"""For fewer packs threads take longer to start than what they would share, where a pack takes no time."""

AT_ONCE = 100
"""Iterations in a launch at most: nothing can stop one."""


@ti.data_oriented
class Krylov:
    """Kernels over all packs; each sum is taken in the order of the packs.

    Args:
        step: what a pack does in a step, by stages that are implicit.

    Attributes:
        found: the numbers, on the host.
        team: who carries the kernels out that take members.
    """

    def __init__(self, step: Step, stages: ImplicitStages) -> None:
        self.step, self.stages, self.real = step, stages, step.real
        self.points, self.ending = step.points, step.ending
        self.equations = NewtonEquations(step, stages)
        self.residual, self.change = self.equations.residual, self.equations.change
        pack, packs = ti.types.vector(LANES, step.real), self.points.capacity
        self.better = ti.field(pack, shape=(3, packs))
        self.direction = ti.field(pack, shape=(3, packs))
        self.image = ti.field(pack, shape=(3, packs))
        self.parts = ti.field(pack, shape=packs)
        self.others = ti.field(pack, shape=packs)
        self.few = packs < MANY
        self.numbers = ti.field(ti.f64, shape=5)
        self.found = self.points.memory.view(self.numbers)
        self.team = Team(self.points.memory)
        springs = [term for term in step.motion.terms if isinstance(term, Springs)]
        rows, pins = SpringRows(springs, self.points), self.ending.pins
        self.bodies = RigidBodies(rows, pins, self.equations.alone, self.residual, self.team)

    @ti.kernel
    def approach(
        self,
        row: ti.i32,
        beginning: ti.i32,
        forgetting: ti.i32,
        packs: ti.i32,
        start: ti.f64,
        now: ti.f64,
        length: ti.f64,
    ):
        """Bring packs to a stage of a step from `now`, s after `start`.

        So many begin the step first, and so many forget the accelerations of the stage.
        """
        ti.loop_config(serialize=self.few)
        for b in range(beginning):
            t0, h = ti.cast(start, self.real), ti.cast(length, self.real)
            self.step.begin(b, t0, ti.cast(now, self.real), h)
        ti.loop_config(serialize=self.few)
        for b in range(forgetting):
            for c in ti.static(range(3)):
                self.stages.slopes[3 * row + c, b] = 0.0 * self.points.mass[b]
        ti.loop_config(serialize=self.few)
        for b in range(packs):
            self._approach(row, b, start + now, length)

    @ti.func
    def _approach(self, row, b, begun, length):
        h = ti.cast(length, self.real)
        self.stages.approach(row, b, self.ending.reaches[b])
        self.ending.pins.place(b, ti.cast(begun, self.real) + self.step.times[row] * h)

    @ti.kernel
    def evaluate(self, i: ti.i32, packs: ti.i32, time: ti.f64):
        """Accelerations at an explicit stage."""
        ti.loop_config(block_dim=SHARE)
        for b in range(packs):
            self.step.evaluate(i, b, ti.cast(time, self.real))

    @ti.kernel
    def descend(
        self,
        i: ti.i32,
        packs: ti.i32,
        members: ti.i32,
        begun: ti.i32,
        anew: ti.i32,
        forcing: ti.f64,
        enough: ti.f64,
        beginning: ti.f64,
        time: ti.f64,
        length: ti.f64,
        factor: ti.f64,
    ):
        """An iteration of Newton's method at stage i of a step: its equations, and conjugate gradients.

        These (Hestenes & Stiefel 1952) go on until r·z is less than a share, squared, of δ·Aδ. Then the accelerations
        are changed, and packs brought to the stage, as by `approach`. They may not end in one launch; the next goes on.

        Args:
            begun: 1 to go on.
            anew: 1 to bring the bodies to these equations; else they are those of earlier ones.
            forcing: the share.
            enough: if r·z is at most so much at once, nothing is changed.
            beginning, time: of the step and of the stage, s.
            length, factor: of the step, and h a, s.
        """
        self.team.gather()
        ti.loop_config(block_dim=1, parallelize=MOST)
        for member in range(members):
            if begun == 0:
                self._set_up(i, member, members, packs, time, factor)
                if anew == 1:
                    self.bodies.refresh(member, members)
            state = self._search(member, members, packs, begun, forcing, enough)
            first, last = self.team.share(member, members, packs)
            if state == CHANGED:
                for b in range(first, last):
                    self.parts[b] = self.equations.take(i, b)
                    self._approach(i, b, beginning, length)
            self.team.meet(members)
            if member == 0:
                self.numbers[STATE] = state
                self.numbers[SIZE] = self._total(self.parts, packs)
                self.numbers[ROUNDING] = self._total(self.equations.rounding, packs)

    @ti.func
    def _set_up(self, i, member, members, packs, time, factor):
        """Newton's equations, with no direction yet."""
        first, last = self.team.share(member, members, packs)
        for b in range(first, last):
            t, s, by = ti.cast(time, self.real), ti.cast(factor, self.real), ti.cast(factor**2, self.real)
            self.equations.linearize(i, b, t, by, s)
            for c in ti.static(range(3)):
                self.direction[c, b] = 0.0 * self.points.mass[b]
                self.image[c, b] = 0.0 * self.points.mass[b]
        self.team.meet(members)

    @ti.func
    def _search(self, member, members, packs, begun, forcing, enough):
        """Conjugate gradients, to their end or for a while; returns how far they are."""
        first, last = self.team.share(member, members, packs)
        left, found, state, iteration = self.numbers[RESIDUAL], self.numbers[FOUND], GOING, 0
        if begun == 0:
            left, found = 0.0, 0.0
        while (state == GOING) & (iteration < AT_ONCE):
            step, old = ti.cast(0.0, ti.f64), left
            at_once = (begun == 0) & (iteration == 0)
            if not at_once:
                for b in range(first, last):
                    self._multiply(b)
                self.team.meet(members)
                # Every member takes the sums, which is sooner done than told.
                total = self._total(self.others, packs)
                step = ti.select(total > 0.0, old / total, 0.0)
                found += step**2 * total
            left = self._precondition(member, members, packs, step)
            self._turn(first, last, step, ti.select(old > 0.0, left / old, 0.0))
            self.team.meet(members)
            state = self._state(left, ti.select(at_once, enough, forcing**2 * found), at_once)
            iteration += 1
        if member == 0:
            self.numbers[RESIDUAL], self.numbers[FOUND] = left, found
        return state

    @ti.func
    def _multiply(self, b):
        """The image of the direction, and their product."""
        image, total = self.equations.multiplied(b, self.direction), 0.0 * self.points.mass[b]
        for c in ti.static(range(3)):
            self.image[c, b] = image[c]
            total += image[c] * self.direction[c, b]
        self.others[b] = total

    @ti.func
    def _precondition(self, member, members, packs, step):
        """Make something better of what a step along the direction leaves of the residual; returns r·z."""
        first, last = self.team.share(member, members, packs)
        for b in range(first, last):
            self._advance(b, ti.cast(step, self.real))
        self.team.meet(members)
        total = self._total(self.parts, packs)
        if ti.static(self.bodies.count > 0):
            total += self.bodies.solve(member, members)
        return total

    @ti.func
    def _advance(self, b, step):
        """What a step along the direction leaves of the residual, and what the particles' own blocks make of that."""
        for c in ti.static(range(3)):
            self.residual[c, b] = self.residual[c, b] - step * self.image[c, b]
        z, total = product(self.equations.inverses, b, self.residual), 0.0 * self.points.mass[b]
        for c in ti.static(range(3)):
            self.better[c, b] = z[c]
            total += z[c] * self.residual[c, b]
        self.parts[b] = total

    @ti.func
    def _turn(self, first, last, length, share_of_old):
        """Take the step, and turn to the next direction: of the preconditioned residual and the last one."""
        step, share = ti.cast(length, self.real), ti.cast(share_of_old, self.real)
        for b in range(first, last):
            x, y, z = self.better[0, b], self.better[1, b], self.better[2, b]
            if ti.static(self.bodies.count > 0):
                row, moves = self.bodies.rows.row(b), self.equations.moves(b)
                if row >= 0:
                    found = self.bodies.moved(row)
                    x += ti.select(moves, found[0], 0.0)
                    y += ti.select(moves, found[1], 0.0)
                    z += ti.select(moves, found[2], 0.0)
            for c in ti.static(range(3)):
                direction = self.direction[c, b]
                self.change[c, b] = self.change[c, b] + step * direction
                self.direction[c, b] = [x, y, z][c] + share * direction

    @ti.func
    def _state(self, left, enough, at_once):
        """How far they are with so much left where so much is enough, at once or after a change."""
        state = GOING
        if not ((left >= 0.0) & (left < math.inf)):
            state = LOST
        elif left <= enough:
            state = ti.select(at_once, KEPT, CHANGED)
        return state

    @ti.func
    def _total(self, parts: ti.template(), packs):
        """The sum of a field of packs."""
        total = ti.Vector.zero(ti.f64, LANES)
        for b in range(packs):
            total += ti.cast(parts[b], ti.f64)
        return total.sum()

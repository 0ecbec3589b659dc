"""Newton's method for implicit steps of coupled particles: its equations, and conjugate gradients that solve them.

The unknowns are the accelerations k of all particles at a stage whose position is x + … + h² a² k and whose velocity is
v + … + h a k. Newton's equations for their change δ are, by mass, (M − h a D − h² a² K) δ = M (f − k), where K = ∂F/∂x
and D = ∂F/∂v.
The matrix is never put together: forces apply theirs to a vector. What would make it indefinite is left out, so that
conjugate gradients converge; Newton's method then needs an iteration or two more and has the same solution.
"""

import taichi as ti

from particlecli.dynamics.coupled.blocks import inverted, product
from particlecli.dynamics.coupled.implicit_stages import ImplicitStages
from particlecli.dynamics.coupled.rigid_bodies import RigidBodies
from particlecli.dynamics.coupled.sharing import SHARE
from particlecli.dynamics.coupled.spring_rows import SpringRows
from particlecli.dynamics.coupled.springs import Springs
from particlecli.dynamics.coupled.step import Step
from particlecli.dynamics.group_plan import LANES

RESIDUAL, SHARE_OF_OLD, LENGTH, FOUND, SIZE, ROUNDING = range(6)
"""Places in the numbers: r·z; β; step length α; δ·Aδ of the change found; Σ m |k|²; what rounding of positions is worth
as δ·Aδ, times h⁴ a⁴."""

MANY = 4096
"""For fewer packs threads take longer to start than what they would share: only the product with the matrix is."""

EPSILON = {ti.f32: 2.0**-24, ti.f64: 2.0**-53}
"""Largest relative error of one rounding."""


@ti.data_oriented
class Krylov:
    """Kernels over all packs; each sum is taken in the order of the packs.

    Args:
        step: what a pack does in a step, by stages that are implicit.
    """

    def __init__(self, step: Step, stages: ImplicitStages) -> None:
        self.step, self.stages = step, stages
        self.motion, self.ending, self.points = step.motion, step.ending, step.points
        self.real = step.real
        pack = ti.types.vector(LANES, step.real)
        packs = self.points.capacity
        self.alone = ti.field(pack, shape=(6, packs))
        self.blocks = ti.field(pack, shape=(6, packs))
        self.inverses = ti.field(pack, shape=(6, packs))
        self.residual = ti.field(pack, shape=(3, packs))
        self.better = ti.field(pack, shape=(3, packs))
        self.direction = ti.field(pack, shape=(3, packs))
        self.image = ti.field(pack, shape=(3, packs))
        self.change = ti.field(pack, shape=(3, packs))
        self.parts = ti.field(pack, shape=(3, packs))
        self.few = packs < MANY
        self.numbers = ti.field(ti.f64, shape=6)
        self.found = self.points.memory.view(self.numbers)
        self.epsilon = EPSILON[step.real]
        springs = [term for term in self.motion.terms if isinstance(term, Springs)]
        self.bodies = RigidBodies(SpringRows(springs, self.points), self.ending.pins, self.alone, self.residual)

    def refresh(self) -> None:
        """Bring the bodies to the present equations; for later ones of the same step they do nearly as well."""
        if self.bodies.count:
            self.bodies.refresh()

    @ti.kernel
    def approach(self, row: ti.i32, beginning: ti.i32, packs: ti.i32, start: ti.f64, now: ti.f64, length: ti.f64):
        """Bring points to a stage of a step from `now`, s after `start`; so many packs begin the step first."""
        ti.loop_config(serialize=self.few)
        for b in range(beginning):
            t0, h = ti.cast(start, self.real), ti.cast(length, self.real)
            self.step.begin(b, t0, ti.cast(now, self.real), h)
        ti.loop_config(serialize=self.few)
        for b in range(packs):
            h = ti.cast(length, self.real)
            self.stages.approach(row, b, self.ending.reaches[b])
            self.ending.pins.place(b, ti.cast(start + now, self.real) + self.step.times[row] * h)

    @ti.kernel
    def evaluate(self, i: ti.i32, packs: ti.i32, time: ti.f64):
        """Accelerations at an explicit stage."""
        ti.loop_config(block_dim=SHARE)
        for b in range(packs):
            self.step.evaluate(i, b, ti.cast(time, self.real))

    @ti.kernel
    def linearize(self, i: ti.i32, packs: ti.i32, time: ti.f64, by_position: ti.f64, by_velocity: ti.f64):
        """Newton's equations at stage i; the factors are h² a², s², and h a, s."""
        ti.loop_config(block_dim=SHARE)
        for b in range(packs):
            t = ti.cast(time, self.real)
            self._linearize(i, b, t, ti.cast(by_position, self.real), ti.cast(by_velocity, self.real))

    @ti.func
    def _linearize(self, i, b, t, by_position, by_velocity):
        moves = self._moves(b)
        mass = ti.select(moves, self.points.mass[b], 1.0)
        a = self.motion.acceleration(b, t)
        both = self.motion.linearize(b, t, by_position, by_velocity)
        rounding = 0.0 * mass
        for c in ti.static((0, 3, 5)):
            stiff = both[c] + both[6 + c]
            rounding += (
                stiff
                * stiff
                / (mass + stiff)
                * (self.epsilon * self.points.state[ti.static((0, 3, 5).index(c)), b]) ** 2
            )
        self.parts[2, b] = ti.select(moves, rounding, 0.0)
        for c in ti.static(range(6)):
            own = mass + both[c] if ti.static(c in (0, 3, 5)) else both[c]
            self.alone[c, b] = own
            self.blocks[c, b] = own + both[6 + c]
        inverse = inverted([self.blocks[c, b] for c in ti.static(range(6))])
        for c in ti.static(range(6)):
            self.inverses[c, b] = inverse[c]
        for c in ti.static(range(3)):
            self.residual[c, b] = ti.select(moves, mass * (a[c] - self.stages.slopes[3 * i + c, b]), 0.0)
            self.change[c, b] = 0.0 * mass
            self.direction[c, b] = 0.0 * mass
            self.image[c, b] = 0.0 * mass

    @ti.func
    def _moves(self, b):
        """Mask of the particles of a pack that the equations are for."""
        return (self.ending.reaches[b] > 0.0) & (self.points.mass[b] > 0.0)

    @ti.kernel
    def iterate(self, packs: ti.i32, begun: ti.i32):
        """An iteration of conjugate gradients (Hestenes & Stiefel 1952); or, not begun, make it ready."""
        ti.loop_config(block_dim=SHARE)
        for b in range(packs * begun):
            self._multiply(b)
        ti.loop_config(serialize=True)
        for _ in range(1):
            self._measure_step(packs * begun)
        ti.loop_config(serialize=self.few)
        for b in range(packs):
            self._advance(b)
        if ti.static(self.bodies.count > 0):
            ti.loop_config(block_dim=1, serialize=self.few)
            for branch in range(self.bodies.factor.branches):
                self.bodies.begin(branch)
        ti.loop_config(serialize=True)
        for _ in range(1):
            self._measure_turn(packs, begun)
        if ti.static(self.bodies.count > 0):
            ti.loop_config(block_dim=1, serialize=self.few)
            for branch in range(self.bodies.factor.branches):
                self.bodies.end(branch)
        ti.loop_config(serialize=self.few)
        for b in range(packs):
            self._turn(b)

    @ti.func
    def _multiply(self, b):
        """The image of the direction."""
        own, others = product(self.blocks, b, self.direction), self.motion.apply(b, self.direction)
        moves, total = self._moves(b), 0.0 * self.points.mass[b]
        for c in ti.static(range(3)):
            image = ti.select(moves, own[c] + others[c], 0.0)
            self.image[c, b] = image
            total += image * self.direction[c, b]
        self.parts[1, b] = total

    @ti.func
    def _measure_step(self, packs):
        """How far to go along the direction, and what is found there; nothing without packs."""
        total = self._total(1, packs)
        self.numbers[LENGTH] = ti.select(total > 0.0, self.numbers[RESIDUAL] / total, 0.0)
        found = ti.select(packs > 0, self.numbers[FOUND], 0.0)
        self.numbers[FOUND] = found + self.numbers[LENGTH] ** 2 * total

    @ti.func
    def _measure_turn(self, packs, begun):
        """Let the bodies see what is left of the residual, and find the share of the last direction."""
        total, old = self._total(0, packs), self.numbers[RESIDUAL]
        if ti.static(self.bodies.count > 0):
            total += self.bodies.turn()
        self.numbers[SHARE_OF_OLD] = ti.select((old > 0.0) & (begun == 1), total / old, 0.0)
        self.numbers[RESIDUAL] = total

    @ti.func
    def _total(self, part: ti.template(), packs):
        """The sum of a part of all packs."""
        total = ti.Vector.zero(ti.f64, LANES)
        for b in range(packs):
            total += ti.cast(self.parts[part, b], ti.f64)
        return total.sum()

    @ti.func
    def _advance(self, b):
        """What a step along the direction leaves of the residual, and what the particles' own blocks make of that."""
        step, total = ti.cast(self.numbers[LENGTH], self.real), 0.0 * self.points.mass[b]
        for c in ti.static(range(3)):
            self.residual[c, b] = self.residual[c, b] - step * self.image[c, b]
        z = product(self.inverses, b, self.residual)
        for c in ti.static(range(3)):
            self.better[c, b] = z[c]
            total += z[c] * self.residual[c, b]
        self.parts[0, b] = total

    @ti.func
    def _turn(self, b):
        """Take the step, and turn to the next direction: of the preconditioned residual and the last one."""
        step, share = ti.cast(self.numbers[LENGTH], self.real), ti.cast(self.numbers[SHARE_OF_OLD], self.real)
        x, y, z = self.better[0, b], self.better[1, b], self.better[2, b]
        if ti.static(self.bodies.count > 0):
            row, moves = self.bodies.rows.row(b), self._moves(b)
            if row >= 0:
                found = self.bodies.moved(row)
                x += ti.select(moves, found[0], 0.0)
                y += ti.select(moves, found[1], 0.0)
                z += ti.select(moves, found[2], 0.0)
        for c in ti.static(range(3)):
            direction = self.direction[c, b]
            self.change[c, b] = self.change[c, b] + step * direction
            self.direction[c, b] = [x, y, z][c] + share * direction

    @ti.kernel
    def forget(self, i: ti.i32, packs: ti.i32):
        """Begin the search for the accelerations of stage i from none."""
        ti.loop_config(serialize=self.few)
        for b in range(packs):
            for c in ti.static(range(3)):
                self.stages.slopes[3 * i + c, b] = 0.0 * self.points.mass[b]

    @ti.kernel
    def update(self, i: ti.i32, packs: ti.i32):
        """Change the accelerations of stage i, and measure them and what rounding is worth."""
        ti.loop_config(serialize=self.few)
        for b in range(packs):
            size, moves = 0.0 * self.points.mass[b], self._moves(b)
            for c in ti.static(range(3)):
                k = self.stages.slopes[3 * i + c, b] + self.change[c, b]
                self.stages.slopes[3 * i + c, b] = k
                size += ti.select(moves, self.points.mass[b] * k**2, 0.0)
            self.parts[0, b] = size
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.numbers[SIZE], self.numbers[ROUNDING] = self._total(0, packs), self._total(2, packs)

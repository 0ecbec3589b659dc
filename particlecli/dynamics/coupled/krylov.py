"""Newton's method for implicit steps of coupled particles: its equations, and conjugate gradients that solve them.

The unknowns are the accelerations k of all particles at a stage whose position is x + … + h² a² k and whose velocity is
v + … + h a k. Newton's equations for their change δ are, by mass, (M − h a D − h² a² K) δ = M (f − k), where K = ∂F/∂x
and D = ∂F/∂v.
The matrix is never put together: forces apply theirs to a vector. What would make it indefinite is left out, so that
conjugate gradients converge; Newton's method then needs an iteration or two more and has the same solution.
"""

import taichi as ti

from particlecli.dynamics.coupled.implicit_stages import ImplicitStages
from particlecli.dynamics.coupled.multigrid import DAMPING, Multigrid, inverted, multiplied, product
from particlecli.dynamics.coupled.sharing import GRAIN, SHARE, TURNS
from particlecli.dynamics.coupled.springs import Springs
from particlecli.dynamics.coupled.step import Step
from particlecli.dynamics.group_plan import LANES

RESIDUAL, LENGTH, SHARE_OF_OLD, ERROR, FOUND, CHANGE, SIZE = range(7)
"""Places in the numbers: r·z; step length α; β; Σ |z|²; Σ |δ|²; Σ |δ|² again, and Σ |k|² + |v|²/h², of Newton."""

IMAGE, DESCENT, SMOOTHING = range(3)
"""What a product with the matrix is for: conjugate gradients, or the preconditioner before and after its correction."""

DIRECTION, GUESS = 0, 3
"""First rows of the vectors that are multiplied."""


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
        self.blocks = ti.field(pack, shape=(6, packs))
        self.inverses = ti.field(pack, shape=(6, packs))
        self.residual = ti.field(pack, shape=(3, packs))
        self.better = ti.field(pack, shape=(3, packs))
        self.vectors = ti.field(pack, shape=(6, packs))
        self.image = ti.field(pack, shape=(3, packs))
        self.change = ti.field(pack, shape=(3, packs))
        self.parts = ti.field(ti.f64, shape=(4, packs))
        self.numbers = ti.field(ti.f64, shape=7)
        self.found = self.points.memory.view(self.numbers)
        self.counter = ti.field(ti.i32, shape=1)
        springs = [term for term in self.motion.terms if isinstance(term, Springs)]
        self.multigrid = Multigrid(springs, self.points, self.ending.pins, self.blocks)

    def refresh(self) -> None:
        """Bring the preconditioner to the present equations."""
        if self.multigrid.levels:
            self.multigrid.refresh()

    @ti.kernel
    def approach(self, row: ti.i32, beginning: ti.i32, packs: ti.i32, start: ti.f64, now: ti.f64, length: ti.f64):
        """Bring points to a stage of a step from `now`, s after `start`; so many packs begin the step first."""
        for b in range(beginning):
            t0, h = ti.cast(start, self.real), ti.cast(length, self.real)
            self.step.begin(b, t0, ti.cast(now, self.real), h)
        for b in range(packs):
            h = ti.cast(length, self.real)
            self.stages.approach(row, b, self.ending.reaches[b])
            self.ending.pins.place(b, ti.cast(start + now, self.real) + self.step.times[row] * h)

    @ti.kernel
    def evaluate(self, i: ti.i32, packs: ti.i32, time: ti.f64):
        """Accelerations at an explicit stage."""
        self.counter[0] = 0
        for turn in range(TURNS):
            if turn % GRAIN == 0:
                first = ti.atomic_add(self.counter[0], SHARE)
                while first < packs:
                    for b in range(first, ti.min(first + SHARE, packs)):
                        self.step.evaluate(i, b, ti.cast(time, self.real))
                    first = ti.atomic_add(self.counter[0], SHARE)

    @ti.kernel
    def linearize(self, i: ti.i32, packs: ti.i32, time: ti.f64, by_position: ti.f64, by_velocity: ti.f64):
        """Newton's equations at stage i; the factors are h² a², s², and h a, s."""
        self.counter[0] = 0
        for turn in range(TURNS):
            if turn % GRAIN == 0:
                first = ti.atomic_add(self.counter[0], SHARE)
                while first < packs:
                    for b in range(first, ti.min(first + SHARE, packs)):
                        t = ti.cast(time, self.real)
                        self._linearize(i, b, t, ti.cast(by_position, self.real), ti.cast(by_velocity, self.real))
                    first = ti.atomic_add(self.counter[0], SHARE)

    @ti.func
    def _linearize(self, i, b, t, by_position, by_velocity):
        moves = (self.ending.reaches[b] > 0.0) & (self.points.mass[b] > 0.0)
        mass = ti.select(moves, self.points.mass[b], 1.0)
        a = self.motion.acceleration(b, t)
        xx, xy, xz, yy, yz, zz = self.motion.linearize(b, t, by_position, by_velocity)
        xx, yy, zz = mass + xx, mass + yy, mass + zz
        block = [xx, xy, xz, yy, yz, zz]
        inverse = inverted(block)
        for c in ti.static(range(6)):
            self.blocks[c, b] = block[c]
            self.inverses[c, b] = inverse[c]
        for c in ti.static(range(3)):
            self.residual[c, b] = ti.select(moves, mass * (a[c] - self.stages.slopes[3 * i + c, b]), 0.0)
            self.change[c, b] = 0.0 * mass
            self.vectors[DIRECTION + c, b] = 0.0 * mass

    def iterate(self, packs: int, *, begun: bool) -> tuple[float, float, float]:
        """An iteration of conjugate gradients (Hestenes & Stiefel 1952); or, not begun, make it ready.

        Returns:
            The square of the error that is left, as the preconditioner measures it: by energy, and Σ |z|², (m/s²)²; and
            Σ |δ|² of the change found so far.
        """
        if begun:
            self._sweep(packs, IMAGE)
        self._advance(packs, int(begun))
        if self.multigrid.levels:
            self._sweep(packs, DESCENT)
            self._correct(packs)
            self._sweep(packs, SMOOTHING)
            self._smooth(packs)
        self._turn(packs, int(begun))
        return self.numbers[RESIDUAL], self.numbers[ERROR], self.numbers[FOUND]

    @ti.kernel
    def _sweep(self, packs: ti.i32, purpose: ti.i32):
        """Multiply the direction, or the guess of the preconditioner, by the matrix."""
        self.counter[0] = 0
        for turn in range(TURNS):
            if turn % GRAIN == 0:
                first = ti.atomic_add(self.counter[0], SHARE)
                while first < packs:
                    for b in range(first, ti.min(first + SHARE, packs)):
                        self._multiply(b, purpose)
                    first = ti.atomic_add(self.counter[0], SHARE)

    @ti.func
    def _multiply(self, b, purpose):
        first = DIRECTION if purpose == IMAGE else GUESS
        own, others = product(self.blocks, b, self.vectors, first), self.motion.apply(b, self.vectors, first)
        moves, total = self._moves(b), 0.0 * self.points.mass[b]
        for c in ti.static(range(3)):
            image = ti.select(moves, own[c] + others[c], 0.0)
            self.image[c, b] = image
            total += image * self.vectors[DIRECTION + c, b]
        if purpose == IMAGE:
            self.parts[1, b] = ti.cast(total.sum(), ti.f64)
        if ti.static(self.multigrid.levels > 0):
            row = self.multigrid.row(b)
            if (purpose == DESCENT) & (row >= 0):
                for c in ti.static(range(3)):
                    self.multigrid.rest[c, row] = self.residual[c, b] - self.image[c, b]

    @ti.func
    def _moves(self, b):
        """Mask of the particles of a pack that the equations are for."""
        return (self.ending.reaches[b] > 0.0) & (self.points.mass[b] > 0.0)

    @ti.func
    def _measure(self, b, better):
        """Keep the preconditioned residual of a pack, and its product with the residual."""
        total, error, found = 0.0 * self.points.mass[b], 0.0 * self.points.mass[b], 0.0 * self.points.mass[b]
        for c in ti.static(range(3)):
            self.better[c, b] = better[c]
            total += better[c] * self.residual[c, b]
            error += better[c] ** 2
            found += self.change[c, b] ** 2
        self.parts[0, b] = ti.cast(total.sum(), ti.f64)
        self.parts[2, b] = ti.cast(error.sum(), ti.f64)
        self.parts[3, b] = ti.cast(found.sum(), ti.f64)

    @ti.func
    def _total(self, part: ti.template(), packs):
        """The sum of a part of all packs."""
        total = ti.cast(0.0, ti.f64)
        for b in range(packs):
            total += self.parts[part, b]
        return total

    @ti.kernel
    def _advance(self, packs: ti.i32, begun: ti.i32):
        """On along the direction; and what the preconditioner, or its first step, makes of the residual."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            total = self._total(1, packs * begun)
            self.numbers[LENGTH] = ti.select(total > 0.0, self.numbers[RESIDUAL] / total, 0.0)
        for b in range(packs):
            step = ti.cast(self.numbers[LENGTH], self.real)
            for c in ti.static(range(3)):
                self.change[c, b] = self.change[c, b] + step * self.vectors[DIRECTION + c, b]
                self.residual[c, b] = self.residual[c, b] - step * self.image[c, b]
            z = product(self.inverses, b, self.residual, 0)
            if ti.static(self.multigrid.levels > 0):
                for c in ti.static(range(3)):
                    self.vectors[GUESS + c, b] = DAMPING * z[c]
            else:
                self._measure(b, z)

    @ti.kernel
    def _correct(self, packs: ti.i32):
        """Add to the guess of the preconditioner what the coarser levels find."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.multigrid.solve()
        for b in range(packs):
            row, moves = self.multigrid.row(b), self._moves(b)
            if row >= 0:
                found = self.multigrid.prolonged(row)
                for c in ti.static(range(3)):
                    self.vectors[GUESS + c, b] = self.vectors[GUESS + c, b] + ti.select(moves, found[c], 0.0)

    @ti.kernel
    def _smooth(self, packs: ti.i32):
        """Improve the guess of the preconditioner after its correction, whose image is known."""
        for b in range(packs):
            rest = [self.residual[c, b] - self.image[c, b] for c in ti.static(range(3))]
            z = multiplied([self.inverses[c, b] for c in ti.static(range(6))], rest)
            self._measure(b, [self.vectors[GUESS + c, b] + DAMPING * z[c] for c in ti.static(range(3))])

    @ti.kernel
    def _turn(self, packs: ti.i32, begun: ti.i32):
        """The next direction."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            total, old = self._total(0, packs), self.numbers[RESIDUAL]
            self.numbers[SHARE_OF_OLD] = ti.select((old > 0.0) & (begun == 1), total / old, 0.0)
            self.numbers[RESIDUAL] = total
            self.numbers[ERROR], self.numbers[FOUND] = self._total(2, packs), self._total(3, packs)
        for b in range(packs):
            share = ti.cast(self.numbers[SHARE_OF_OLD], self.real)
            for c in ti.static(range(3)):
                self.vectors[DIRECTION + c, b] = self.better[c, b] + share * self.vectors[DIRECTION + c, b]

    @ti.kernel
    def forget(self, packs: ti.i32):
        """Begin the next search for accelerations from none, where the last has led astray."""
        for b in range(packs):
            for c in range(3 * self.stages.stages):
                self.stages.slopes[c, b] = 0.0 * self.points.mass[b]

    @ti.kernel
    def update(self, i: ti.i32, packs: ti.i32, length: ti.f64):
        """Change the accelerations of stage i, and measure by how much."""
        for b in range(packs):
            changed, size = 0.0 * self.points.mass[b], 0.0 * self.points.mass[b]
            moves = self.ending.reaches[b] > 0.0
            for c in ti.static(range(3)):
                k = self.stages.slopes[3 * i + c, b] + self.change[c, b]
                self.stages.slopes[3 * i + c, b] = k
                changed += self.change[c, b] ** 2
                size += k**2 + (self.points.state[c + 3, b] / ti.cast(length, self.real)) ** 2
            self.parts[0, b] = ti.cast(changed.sum(), ti.f64)
            self.parts[1, b] = ti.cast(ti.select(moves, size, 0.0).sum(), ti.f64)
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.numbers[CHANGE], self.numbers[SIZE] = 0.0, 0.0
            for b in range(packs):
                self.numbers[CHANGE] = self.numbers[CHANGE] + self.parts[0, b]
                self.numbers[SIZE] = self.numbers[SIZE] + self.parts[1, b]

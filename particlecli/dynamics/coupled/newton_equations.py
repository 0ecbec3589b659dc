"""The equations of Newton's method for implicit steps of coupled particles."""

import taichi as ti

from particlecli.dynamics.coupled.blocks import inverted, product
from particlecli.dynamics.coupled.implicit_stages import ImplicitStages
from particlecli.dynamics.coupled.step import Step
from particlecli.dynamics.group_plan import LANES

EPSILON = {ti.f32: 2.0**-24, ti.f64: 2.0**-53}
"""Largest relative error of one rounding."""


@ti.data_oriented
class NewtonEquations:
    """(M − h a D − h² a² K) δ = M (f − k), where K = ∂F/∂x and D = ∂F/∂v, for the change δ of the accelerations k.

    k are those of all particles at a stage whose position is x + … + h² a² k and whose velocity is v + … + h a k.
    The matrix is never put together: forces apply theirs to a vector. What would make it indefinite is left out, so
    that conjugate gradients converge; Newton's method then needs an iteration or two more and has the same solution.

    Args:
        step: what a pack does in a step, by stages that are implicit.

    Attributes:
        alone: field of packs, shape (6, packs): the blocks xx, xy, xz, yy, yz, zz of particles, kg, but for what forces
            between them add.
        inverses: the inverses of the whole blocks on the diagonal, 1/kg.
        residual: field of packs, shape (3, packs): what is left of the equations, N; zero for what does not move.
        change: field of packs, shape (3, packs): δ, m/s².
        rounding: field of packs, shape (packs): what rounding of positions is worth as δ·Aδ, times h⁴ a⁴.
    """

    def __init__(self, step: Step, stages: ImplicitStages) -> None:
        self.stages = stages
        self.motion, self.ending, self.points = step.motion, step.ending, step.points
        pack, packs = ti.types.vector(LANES, step.real), self.points.capacity
        self.alone = ti.field(pack, shape=(6, packs))
        self.blocks = ti.field(pack, shape=(6, packs))
        self.inverses = ti.field(pack, shape=(6, packs))
        self.residual = ti.field(pack, shape=(3, packs))
        self.change = ti.field(pack, shape=(3, packs))
        self.rounding = ti.field(pack, shape=packs)
        self.epsilon = EPSILON[step.real]

    @ti.func
    def moves(self, b):
        """Mask of the particles of a pack that the equations are for."""
        return (self.ending.reaches[b] > 0.0) & (self.points.mass[b] > 0.0)

    @ti.func
    def linearize(self, i, b, t, by_position, by_velocity):
        """The equations of a pack at stage i, where the change is zero yet; the factors are h² a², s², and h a, s."""
        moves = self.moves(b)
        mass = ti.select(moves, self.points.mass[b], 1.0)
        a = self.motion.acceleration(b, t)
        both = self.motion.linearize(b, t, by_position, by_velocity)
        rounding = 0.0 * mass
        for c in ti.static((0, 3, 5)):
            stiff, place = both[c] + both[6 + c], self.points.state[ti.static((0, 3, 5).index(c)), b]
            rounding += stiff * stiff / (mass + stiff) * (self.epsilon * place) ** 2
        self.rounding[b] = ti.select(moves, rounding, 0.0)
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

    @ti.func
    def multiplied(self, b, vectors: ti.template()):
        """The matrix times vectors, of a pack: three packs, zero for what does not move."""
        own, others, moves = product(self.blocks, b, vectors), self.motion.apply(b, vectors), self.moves(b)
        return [ti.select(moves, own[c] + others[c], 0.0) for c in ti.static(range(3))]

    @ti.func
    def take(self, i, b):
        """Change the accelerations of stage i; returns m |k|² of a pack."""
        size, moves = 0.0 * self.points.mass[b], self.moves(b)
        for c in ti.static(range(3)):
            k = self.stages.slopes[3 * i + c, b] + self.change[c, b]
            self.stages.slopes[3 * i + c, b] = k
            size += ti.select(moves, self.points.mass[b] * k**2, 0.0)
        return size

"""Stages of steps of coupled particles, by the same schemes as data as those of single particles.

A scheme is a number of evaluations at given times; after each, packs move on to the next stage, after the last to the
end of the step. What a pack does in a stage depends on nothing but its own accelerations, so packs go in any order.
"""

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.implicit_stages import ImplicitStages
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.coupled.slopes import Slopes
from particlecli.dynamics.integrators.base import (
    AdaptiveRungeKutta,
    AnyScheme,
    ExplicitRungeKutta,
    ImplicitRungeKutta,
    Splitting,
)


@ti.data_oriented
class RungeKuttaStages(Slopes):
    """Explicit Runge–Kutta stages, from the accelerations alone.

    As dx/dt = v, x_i = x + c_i h v + h² Σ (a²)_ij k_j and v_i = v + h Σ a_ij k_j with the accelerations k_j: the same
    method with half the slopes to keep.

    Attributes:
        times: of the evaluations, in steps.
        repeats: whether the last evaluation serves as the first of the next step.
    """

    repeats = False

    def __init__(self, scheme: ExplicitRungeKutta | AdaptiveRungeKutta, points: Points) -> None:
        super().__init__(points, len(scheme.b))
        self.times = list(scheme.c)
        self.stages = len(scheme.b)
        weights = [*scheme.a, scheme.b]
        self.coarse = False
        if isinstance(scheme, AdaptiveRungeKutta):
            weights += [scheme.error, scheme.coarse_error or ()]
            self.coarse = scheme.coarse_error is not None
        a = np.array([(*row, *(0.0,) * (self.stages - len(row))) for row in weights])
        # For each row the share of the velocity, then the weights for positions, then those for velocities.
        shares = [*scheme.c, 1.0, 0.0, 0.0][: len(a)]
        table = np.column_stack([shares, a @ a[: self.stages], a])
        self.table = points.memory.table(points.real, table)

    @ti.func
    def follow(self, i, b, h):
        """Move on after evaluation i; h is the length of the step, s, a pack."""
        moved = self._change(i + 1, b, h)
        for c in ti.static(range(6)):
            self.points.state[c, b] = self.base[c, b] + moved[c]

    @ti.func
    def error(self, b, h, tolerance):
        """How wrong the step is, a pack: up to 1 is tolerated; `tolerance` as of `AdaptiveStepper.attempt`."""
        fine = self._norm(b, self._change(self.stages + 1, b, h), tolerance)
        if ti.static(self.coarse):
            coarse = self._norm(b, self._change(self.stages + 2, b, h), tolerance)
            fine = fine * fine / (ti.sqrt(fine * fine + 0.01 * coarse * coarse) + 1e-30)
        return fine

    @ti.func
    def _change(self, row, b, h):
        """What a row of weights adds to the state, six packs."""
        zero = 0.0 * h
        x, y, z, u, v, w = zero, zero, zero, zero, zero, zero
        for j in range(ti.min(row, self.stages)):
            by_position, by_velocity = self.table[row, 1 + j], self.table[row, 1 + self.stages + j]
            kx, ky, kz = self.slopes[3 * j, b], self.slopes[3 * j + 1, b], self.slopes[3 * j + 2, b]
            x, y, z = x + by_position * kx, y + by_position * ky, z + by_position * kz
            u, v, w = u + by_velocity * kx, v + by_velocity * ky, w + by_velocity * kz
        share = self.table[row, 0]
        return [
            h * (share * self.base[3, b] + h * x),
            h * (share * self.base[4, b] + h * y),
            h * (share * self.base[5, b] + h * z),
            h * u,
            h * v,
            h * w,
        ]

    @ti.func
    def _norm(self, b, error, tolerance):
        total = 0.0 * error[0]
        for c in ti.static(range(6)):
            size = ti.max(ti.abs(self.base[c, b]), ti.abs(self.points.state[c, b]))
            total += (error[c] / (tolerance * ti.max(1.0, size))) ** 2
        return ti.sqrt(total / 6.0)


@ti.data_oriented
class SplittingStages(Slopes):
    """Kicks, each with the drift after it. Attributes as of `RungeKuttaStages`."""

    def __init__(self, scheme: Splitting, points: Points) -> None:
        super().__init__(points, 1)
        kicks = [i for i, (kind, _) in enumerate(scheme.moves) if kind == "kick"]
        drifts = [
            sum(share for _, share in scheme.moves[i + 1 : j]) for i, j in zip(kicks, [*kicks[1:], None], strict=True)
        ]
        if kicks[0] != 0:
            raise ValueError("a splitting must begin with a kick")
        self.stages = len(kicks)
        self.times = [sum(drifts[:i]) for i in range(self.stages)]
        self.repeats = self.stages > 1 and drifts[-1] == 0.0
        shares = np.array([[scheme.moves[i][1] for i in kicks], drifts])
        self.shares = points.memory.table(points.real, shares)

    @ti.func
    def keep(self, i, b, a):
        """Keep the accelerations, three packs, until the next ones."""
        for c in ti.static(range(3)):
            self.slopes[c, b] = a[c]

    @ti.func
    def follow(self, i, b, h):
        """The kick of evaluation i, and the drift after it; h is the length of the step, s, a pack."""
        kick, drift = self.shares[0, i] * h, self.shares[1, i] * h
        for c in ti.static(range(3)):
            velocity = self.points.state[c + 3, b] + kick * self.slopes[c, b]
            self.points.state[c + 3, b] = velocity
            self.points.state[c, b] = self.points.state[c, b] + drift * velocity


Stages = RungeKuttaStages | SplittingStages | ImplicitStages


def stages(scheme: AnyScheme, points: Points) -> Stages:
    """The stages of a scheme on coupled particles."""
    match scheme:
        case ExplicitRungeKutta() | AdaptiveRungeKutta():
            return RungeKuttaStages(scheme, points)
        case Splitting():
            return SplittingStages(scheme, points)
        case ImplicitRungeKutta() if scheme.diagonally_implicit:
            return ImplicitStages(scheme, points)
        case _:
            raise ValueError(f"{type(scheme).__name__} does not advance coupled particles")

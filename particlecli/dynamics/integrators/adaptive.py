"""Steps of particles that each choose their own, by the estimated error. Works on single particles, not on packs.

Written out for packs, twelve stages take LLVM ten seconds and more; as a loop over the stages of one particle they
take a third of a second, and no particle has to follow the pace of the slowest in its pack.
"""

import numpy as np
import taichi as ti

from particlecli.dynamics.algebra import bound
from particlecli.dynamics.integrators.base import AdaptiveRungeKutta
from particlecli.dynamics.memory import FieldMemory

SAFETY = 0.9
SMALLEST_CHANGE, LARGEST_CHANGE = 0.2, 8.0
"""Bounds of the factor by which a step may change."""


@ti.data_oriented
class AdaptiveStepper:
    """One step of an embedded Runge–Kutta method, with its error in units of what is tolerated.

    Args:
        scheme: the method.
        motion: the equations of motion.
        real: type of the numbers.
        memory: where its table goes.
    """

    def __init__(self, scheme: AdaptiveRungeKutta, motion, real, memory: FieldMemory) -> None:
        self.scheme = scheme
        self.motion = motion
        self.stages = len(scheme.b)
        self.has_coarse = scheme.coarse_error is not None
        coarse = scheme.coarse_error if scheme.coarse_error is not None else (0.0,) * self.stages
        rows = [(*row, *(0.0,) * (self.stages - len(row))) for row in scheme.a]
        self.table = memory.table(real, np.array([*rows, scheme.b, scheme.error, coarse, scheme.c]))
        self.slopes = ti.types.vector(6 * self.stages, real)

    @ti.func
    def step(self, p, state, t, h, body):
        """The state after a step of length h from time t."""
        slopes = self._slopes(p, state, t, h, body)
        return self._combined(state, h, self.stages, slopes)

    @ti.func
    def attempt(self, p, state, t, h, body, tolerance):
        """The state after a step of length h from time t, and its error: up to 1 is tolerated.

        `tolerance` is in m and m/s, and relative to the state where that is larger than 1.
        """
        slopes = self._slopes(p, state, t, h, body)
        new = self._combined(state, h, self.stages, slopes)
        zero = [bound(0.0 * value) for value in state]
        fine = self._combined(zero, h, self.stages + 1, slopes)
        error = self._norm(state, new, fine, tolerance)
        if ti.static(self.has_coarse):
            coarse = self._norm(state, new, self._combined(zero, h, self.stages + 2, slopes), tolerance)
            error = error * error / (ti.sqrt(error * error + 0.01 * coarse * coarse) + 1e-30)
        return new + [error]

    @ti.func
    def _slopes(self, p, state, t, h, body):
        slopes = self.slopes(0.0)
        for i in range(self.stages):
            stage = self._combined(state, h, i, slopes)
            slope = self.motion.derivative(p, stage, t + self.table[self.stages + 3, i] * h, body)
            for c in ti.static(range(6)):
                slopes[6 * i + c] = slope[c]
        return slopes

    @ti.func
    def _combined(self, base, h, row, slopes):
        """base + h Σ table[row, j] slopes[j]."""
        x, y, z, u, v, w = base[0], base[1], base[2], base[3], base[4], base[5]
        for j in range(ti.min(row, self.stages)):
            weight = h * self.table[row, j]
            x += weight * slopes[6 * j]
            y += weight * slopes[6 * j + 1]
            z += weight * slopes[6 * j + 2]
            u += weight * slopes[6 * j + 3]
            v += weight * slopes[6 * j + 4]
            w += weight * slopes[6 * j + 5]
        return [x, y, z, u, v, w]

    @ti.func
    def _norm(self, old, new, error, tolerance):
        """Root mean square of the errors of the components, each by what is tolerated in it."""
        total = 0.0 * error[0]
        for c in ti.static(range(6)):
            allowed = tolerance * ti.max(1.0, ti.max(ti.abs(old[c]), ti.abs(new[c])))
            total += (error[c] / allowed) ** 2
        return ti.sqrt(total / 6.0)

    @ti.func
    def change(self, error, last):
        """The factor by which the next step is longer, given the errors of this step and the one before."""
        factor = SAFETY * ti.pow(ti.max(error, 1e-10), -self.scheme.exponent) * ti.pow(last, self.scheme.memory)
        return ti.min(ti.max(factor, SMALLEST_CHANGE), LARGEST_CHANGE)

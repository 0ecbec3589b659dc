"""Implicit Runge–Kutta steps by Newton's method, with the Jacobians of forces and flows, particle by particle."""

import math

import numpy as np
import taichi as ti

from particlecli.dynamics.algebra import add, bound, mul
from particlecli.dynamics.integrators.base import ImplicitRungeKutta
from particlecli.dynamics.memory import FieldMemory

MOST_ITERATIONS = 20
"""Newton iterations, after which a step has failed."""

EPSILON = {ti.f32: 2.0**-24, ti.f64: 2.0**-53}
"""Largest relative error of one rounding."""

CONVERGED = 4.0
"""A change of the velocity by so many roundings of it is none."""

STUCK, NOISY = 16.0, 1000.0
"""Changes that hardly get smaller, or not at all, are rounding where they move a particle by at most so many
roundings of its position."""


@ti.data_oriented
class ImplicitStepper:
    """One step of an implicit Runge–Kutta method: k_i = f(y + h Σ a_ij k_j, t + c_i h), y += h Σ b_i k_i.

    The unknowns k are the accelerations at the stages, for a first-order group the velocities. As positions follow
    from velocities and these from accelerations, Newton's method for s stages takes the 3s equations
    (δ_ij − h a_ij D_i − h² (a²)_ij K_i) δk_j = f_i − k_i with the Jacobians K = ∂a/∂x and D = ∂a/∂v at each stage.

    Args:
        scheme: the method.
        motion: the equations of motion.
        real: type of the numbers, ti.f32 or ti.f64.
        memory: where its table goes.
    """

    def __init__(self, scheme: ImplicitRungeKutta, motion, real, memory: FieldMemory) -> None:
        self.scheme = scheme
        self.motion = motion
        self.real = real
        self.epsilon = EPSILON[real]
        self.stages = len(scheme.b)
        self.early = scheme.explicit_stages
        self.unknowns = 3 * (self.stages - self.early)
        self.width = self.unknowns + 1
        self.slopes = ti.types.vector(3 * self.stages, real)
        self.equations = ti.types.vector(self.unknowns * self.width, real)
        a = np.array([*scheme.a, scheme.b])
        # One row for each stage and one for the step: weights, their product with a, and the time.
        rows = np.column_stack([a, a @ np.array(scheme.a), [*scheme.c, 1.0]])
        self.table = memory.table(real, rows)

    @ti.func
    def step(self, p, state, t, h, body):
        """The state after a step of length h from time t, of scalars; NaN where Newton's method does not converge."""
        k = self.slopes(0.0)
        for i in ti.static(range(self.early)):
            slope = self._slope(self.motion.derivative(p, state, t, body))
            for r in ti.static(range(3)):
                k[3 * i + r] = slope[r]
        before, iteration, pending = ti.cast(0.0, self.real), 0, True
        while pending & (iteration < MOST_ITERATIONS) & (before < math.inf):
            m = self._equations(p, state, t, h, body, k)
            size = ti.cast(0.0, self.real)
            self._solve(m)
            for n in range(self.unknowns):
                change = m[n * self.width + self.unknowns]
                k[3 * self.early + n] += change
                size += ti.abs(h * change)
            pending = not self._converged(state, h, k, size, before)
            before = size
            iteration += 1
        failure = ti.select(pending, math.nan, 0.0)
        new = self._moved(state, h, k, self.stages)
        return [bound(new[c] + failure) for c in ti.static(range(6))]

    @ti.func
    def _equations(self, p, state, t, h, body, k):
        """Newton's equations for the slopes that are solved for: rows of a matrix and the right-hand side."""
        m = self.equations(0.0)
        for i in range(self.early, self.stages):
            stage = self._moved(state, h, k, i)
            now = t + self.table[i, 2 * self.stages] * h
            slope = self._slope(self.motion.derivative(p, stage, now, body))
            of_position, of_slope = self._jacobians(p, stage, now, body)
            for r in ti.static(range(3)):
                row = (3 * (i - self.early) + r) * self.width
                for j in range(self.early, self.stages):
                    once, twice = h * self.table[i, j], h * h * self.table[i, self.stages + j]
                    for c in ti.static(range(3)):
                        m[row + 3 * (j - self.early) + c] = -add(
                            mul(once, of_slope[r][c]), mul(twice, of_position[r][c])
                        )
                m[row + 3 * (i - self.early) + r] += 1.0
                m[row + self.unknowns] = slope[r] - k[3 * i + r]
        return m

    @ti.func
    def _solve(self, m: ti.template()):
        """Gaussian elimination with partial pivoting; the solution takes the place of the right-hand side."""
        for i in range(self.unknowns):
            pivot = i
            for j in range(i + 1, self.unknowns):
                if ti.abs(m[j * self.width + i]) > ti.abs(m[pivot * self.width + i]):
                    pivot = j
            if pivot != i:
                for c in range(i, self.width):
                    upper, lower = m[i * self.width + c], m[pivot * self.width + c]
                    m[i * self.width + c], m[pivot * self.width + c] = lower, upper
            for j in range(i + 1, self.unknowns):
                factor = m[j * self.width + i] / m[i * self.width + i]
                for c in range(i + 1, self.width):
                    m[j * self.width + c] -= factor * m[i * self.width + c]
        for back in range(self.unknowns):
            i = self.unknowns - 1 - back
            rest = m[i * self.width + self.unknowns]
            for c in range(i + 1, self.unknowns):
                rest -= m[i * self.width + c] * m[c * self.width + self.unknowns]
            m[i * self.width + self.unknowns] = rest / m[i * self.width + i]

    @ti.func
    def _moved(self, state, h, k, row):
        """The state at a stage, or in the last row of the table after the step."""
        x0, x1, x2 = state[0] * 0.0, state[0] * 0.0, state[0] * 0.0
        v0, v1, v2 = state[0] * 0.0, state[0] * 0.0, state[0] * 0.0
        for j in range(self.stages):
            once, twice = self.table[row, j], self.table[row, self.stages + j]
            v0 += once * k[3 * j]
            v1 += once * k[3 * j + 1]
            v2 += once * k[3 * j + 2]
            x0 += twice * k[3 * j]
            x1 += twice * k[3 * j + 1]
            x2 += twice * k[3 * j + 2]
        if ti.static(self.motion.first_order):
            return [state[0] + h * v0, state[1] + h * v1, state[2] + h * v2, state[3], state[4], state[5]]
        c = self.table[row, 2 * self.stages]
        return [
            bound(state[0] + h * (c * state[3] + h * x0)),
            bound(state[1] + h * (c * state[4] + h * x1)),
            bound(state[2] + h * (c * state[5] + h * x2)),
            bound(state[3] + h * v0),
            bound(state[4] + h * v1),
            bound(state[5] + h * v2),
        ]

    def _slope(self, derivative):
        return derivative[:3] if self.motion.first_order else derivative[3:]

    def _jacobians(self, p, stage, t, body):
        """The derivatives of the slope by position and by what the slope advances."""
        first, second = self.motion.jacobian(p, stage, t, body)
        return (second, first) if self.motion.first_order else (first, second)

    @ti.func
    def _converged(self, state, h, k, size, before):
        """Whether nothing of note is left to correct.

        That is so where what the last two corrections let expect of the next is within rounding, or where the
        corrections have stopped falling and their effect on the position is within its rounding.
        """
        grown = size * 0.0
        for n in range(3 * self.stages):
            grown += ti.abs(h * k[n])
        extent = ti.abs(state[0]) + ti.abs(state[1]) + ti.abs(state[2])
        speed, reach = extent + grown, size
        if ti.static(self.motion.first_order):
            extent = speed
        else:
            speed = ti.abs(state[3]) + ti.abs(state[4]) + ti.abs(state[5]) + grown
            extent += ti.abs(h) * speed
            reach = ti.abs(h) * size
        fall = ti.max(before - size, 0.0)
        negligible = CONVERGED * self.epsilon * speed
        stuck = (2.0 * size > before) & (reach <= STUCK * self.epsilon * extent)
        noisy = (size >= before) & (reach <= NOISY * self.epsilon * extent)
        return (size <= negligible) | (size * size <= negligible * fall) | ((before > 0.0) & (stuck | noisy))

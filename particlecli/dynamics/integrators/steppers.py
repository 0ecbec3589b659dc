"""Steppers: Taichi functions that carry out a scheme given as data, on packs held in registers.

A state is a list of packs [x, y, z, u, v, w] (first order: [x, y, z]); `motion.derivative(p, state, t, body)`
returns the list of their time derivatives.
"""

import taichi as ti

from particlecli.dynamics.algebra import add, bound, combination, mul
from particlecli.dynamics.integrators.adaptive import AdaptiveStepper
from particlecli.dynamics.integrators.base import (
    AdaptiveRungeKutta,
    AnyScheme,
    ClosedForm,
    ExplicitRungeKutta,
    ImplicitRungeKutta,
    Splitting,
)
from particlecli.dynamics.integrators.exact import ExactStepper
from particlecli.dynamics.integrators.implicit import ImplicitStepper
from particlecli.dynamics.integrators.lanes import LaneByLane
from particlecli.dynamics.memory import FieldMemory


@ti.data_oriented
class RungeKuttaStepper:
    """One step of an explicit Runge–Kutta method: x += h Σ b_i k_i, k_i = f(x + h Σ a_ij k_j, t + c_i h).

    Where each stage needs only the slope before it, the stages are a loop in the kernel, which compiles several
    times faster and runs as fast; otherwise they are written out.
    """

    def __init__(self, scheme: ExplicitRungeKutta, motion) -> None:
        self.scheme = scheme
        self.motion = motion
        self.stages = len(scheme.b)
        self.chained = self.stages > 1 and not any(any(row[:-1]) for row in scheme.a)
        self.ahead = (*(row[-1] for row in scheme.a[1:]), 0.0)

    @ti.func
    def step(self, p, state, t, h, body):
        """The state after a step of length h from time t."""
        if ti.static(self.chained):
            return self._looped(p, state, t, h, body)
        slopes = []
        for i in ti.static(range(self.stages)):
            stage = combination(state, h, self.scheme.a[i], slopes)
            slopes.append(self.motion.derivative(p, stage, add(t, mul(self.scheme.c[i], h)), body))
        return combination(state, h, self.scheme.b, slopes)

    @ti.func
    def _looped(self, p, state, t, h, body):
        x, y, z, u, v, w = state[0], state[1], state[2], state[3], state[4], state[5]
        total = [bound(0.0 * state[c]) for c in ti.static(range(6))]
        for i in range(self.stages):
            slope = self.motion.derivative(p, [x, y, z, u, v, w], t + picked(self.scheme.c, i) * h, body)
            for c in ti.static(range(6)):
                total[c] += mul(picked(self.scheme.b, i), slope[c])
            x, y, z, u, v, w = [
                bound(add(state[c], mul(picked(self.ahead, i) * h, slope[c]))) for c in ti.static(range(6))
            ]
        return [bound(state[c] + h * total[c]) for c in ti.static(range(6))]


def picked(values, i):
    """The i-th of a few constants, i known only when the kernel runs."""
    chosen = values[0]
    for place, value in enumerate(values[1:], start=1):
        chosen = ti.select(i == place, value, chosen)
    return bound(chosen)


@ti.data_oriented
class SplittingStepper:
    """One step of a splitting: kicks and drifts in turn, in a loop of the kernel, each kick at the time drifted to."""

    def __init__(self, scheme: Splitting, motion) -> None:
        self.kicks, self.drifts = scheme.rounds
        self.times = [sum(self.drifts[:i]) for i in range(len(self.drifts))]
        self.motion = motion

    @ti.func
    def step(self, p, state, t, h, body):
        """The state after a step of length h from time t."""
        if ti.static(len(self.kicks) == 1):
            return self._round(p, state, t, h, body, self.kicks[0], self.drifts[0])
        x, y, z, u, v, w = state[0], state[1], state[2], state[3], state[4], state[5]
        for i in range(len(self.kicks)):
            kick, drift, now = picked(self.kicks, i), picked(self.drifts, i), t + picked(self.times, i) * h
            x, y, z, u, v, w = self._round(p, [x, y, z, u, v, w], now, h, body, kick, drift)
        return [x, y, z, u, v, w]

    @ti.func
    def _round(self, p, state, t, h, body, kick, drift):
        slope = self.motion.derivative(p, state, t, body)
        speeds = [bound(add(state[c], mul(mul(kick, h), slope[c]))) for c in ti.static(range(3, 6))]
        return [bound(add(state[c], mul(mul(drift, h), speeds[c]))) for c in ti.static(range(3))] + speeds


def stepper(scheme: AnyScheme, motion, real, memory: FieldMemory):
    """The stepper that carries out a scheme on equations of motion.

    Args:
        scheme: the scheme.
        motion: the equations of motion.
        real: type of the numbers, ti.f32 or ti.f64.
        memory: where its tables go.
    """
    match scheme:
        case ExplicitRungeKutta():
            return RungeKuttaStepper(scheme, motion)
        case Splitting():
            return SplittingStepper(scheme, motion)
        case AdaptiveRungeKutta():
            return AdaptiveStepper(scheme, motion, real, memory)
        case ImplicitRungeKutta():
            return LaneByLane(ImplicitStepper(scheme, motion, real, memory))
        case ClosedForm():
            return LaneByLane(ExactStepper(motion))

"""Implicit steps of coupled particles: Newton's method, from launch to launch."""

from __future__ import annotations

import math
from collections.abc import Callable

from particlecli.dynamics.coupled.implicit_stages import ImplicitStages
from particlecli.dynamics.coupled.krylov import CHANGE, SIZE, Krylov
from particlecli.errors import SimulationError

ACCURACY = {4: 1e-3, 8: 1e-8}
"""By bytes of a number: what the last change of the accelerations may be, in parts of them and of speed over step, or
of the largest of these so far: where everything comes to rest, only rounding is left to be right about."""

FORCING = 0.1
"""Conjugate gradients end when the error, as their preconditioner measures it, is this share of what it was, in energy,
and of the change that they have found, in size: energy alone is that of stiff modes, and soft ones would not be solved
for."""

MOST_ITERATIONS, MOST_GRADIENTS = 25, 4000
"""Iterations of Newton's method, and of conjugate gradients in each, after which a step is cut in two."""

MOST_CUTS = 8
"""How often a step is cut in two before the run stops."""


class Newton:
    """Steps of a scheme whose stages are solved for one after the other.

    Args:
        krylov: the kernels.
        stages: the scheme.
        prepare: gets forces ready at a time, s.
        revert: brings so many packs back to the beginning of the step.
        end: ends a step, given its start, now and length.
        real_bytes: size of a number.
    """

    def __init__(
        self,
        krylov: Krylov,
        stages: ImplicitStages,
        prepare: Callable[[float], None],
        revert: Callable[[int], None],
        end: Callable[[float, float, float], None],
        real_bytes: int,
    ) -> None:
        self._krylov, self._stages = krylov, stages
        self._prepare, self._revert, self._end = prepare, revert, end
        self._accuracy = ACCURACY[real_bytes]
        self.restart()

    def restart(self) -> None:
        """Forget how large accelerations were."""
        self._left = self._largest = 0.0

    def compile(self) -> None:
        """Compile the kernels, by advancing nobody."""
        self._krylov.approach(0, 0, 0, 0.0, 0.0, 1.0)
        self._krylov.evaluate(0, 0, 0.0)
        self._krylov.linearize(0, 0, 0.0, 1.0, 1.0)
        self._krylov.refresh()
        self._krylov.iterate(0, begun=True)
        self._krylov.update(0, 0, 1.0)
        self._krylov.forget(0)

    def step(self, packs: int, start: float, now: float, h: float, cuts: int = 0) -> int:
        """A step of length h from `now`, s after `start`; returns how many evaluations it took.

        Raises:
            SimulationError: Newton's method does not converge, however short the step.
        """
        found, evaluations = self._solve(packs, start, now, h)
        if found:
            self._krylov.approach(self._stages.stages, 0, packs, start, now, h)
            self._end(start, now, h)
            return evaluations
        if cuts == MOST_CUTS:
            raise SimulationError(
                f"the equations of the implicit step at t = {start + now:.6g} s have no solution that Newton's method "
                f"finds, even for a step of {h:.3g} s: the accelerations still change by {self._left:.3g} of "
                f"themselves, and {self._accuracy:g} is wanted. Try a smaller integrator.dt, less stiffness, or "
                "precision: double"
            )
        self._revert(packs)
        self._krylov.forget(packs)
        evaluations += self.step(packs, start, now, h / 2, cuts + 1)
        return evaluations + self.step(packs, start, now + h / 2, h / 2, cuts + 1)

    def _solve(self, packs: int, start: float, now: float, h: float) -> tuple[bool, int]:
        """Whether the stages of a step were found, and how many evaluations that took."""
        evaluations = self._stages.explicit
        for i in range(evaluations):
            self._krylov.approach(i, packs if i == 0 else 0, packs, start, now, h)
            time = start + now + self._stages.times[i] * h
            self._prepare(time)
            self._krylov.evaluate(i, packs, time)
        for i in range(self._stages.explicit, self._stages.stages):
            found, more = self._solve_stage(i, packs, start, now, h)
            evaluations += more
            if not found:
                return False, evaluations
        return True, evaluations

    def _solve_stage(self, i: int, packs: int, start: float, now: float, h: float) -> tuple[bool, int]:
        """Whether a stage was found, from where it was in the step before, and how many evaluations that took."""
        factor, time = h * self._stages.own_weights[i], start + now + self._stages.times[i] * h
        smallest, evaluations = math.inf, 0
        for iteration in range(MOST_ITERATIONS):
            self._krylov.approach(i, packs if iteration == 0 and i == 0 else 0, packs, start, now, h)
            self._prepare(time)
            self._krylov.linearize(i, packs, time, factor**2, factor)
            evaluations += 1
            if not self._descend(packs):
                return False, evaluations
            self._krylov.update(i, packs, h)
            numbers = self._krylov.found.array
            if not math.isfinite(numbers[CHANGE] + numbers[SIZE]):
                return False, evaluations
            largest = max(self._largest, numbers[SIZE])
            self._left = math.sqrt(numbers[CHANGE] / largest) if largest > 0 else 0.0
            if self._left <= self._accuracy:
                self._largest = largest
                return True, evaluations
            if not self._left < 1e3 * smallest:
                return False, evaluations
            smallest = min(smallest, self._left)
        return False, evaluations

    def _descend(self, packs: int) -> bool:
        """Solve Newton's equations; whether conjugate gradients converged."""
        self._krylov.refresh()
        first = left = self._krylov.iterate(packs, begun=False)[0]
        for _ in range(MOST_GRADIENTS):
            if left == 0.0:
                return True
            left, error, found = self._krylov.iterate(packs, begun=True)
            if not 0.0 <= left < math.inf:
                return False
            if left <= FORCING**2 * first and error <= FORCING**2 * found:
                return True
        return False

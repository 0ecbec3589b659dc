"""Implicit steps of coupled particles: Newton's method, from launch to launch."""

from __future__ import annotations

import math
from collections.abc import Callable

from particlecli.dynamics.coupled.implicit_stages import ImplicitStages
from particlecli.dynamics.coupled.krylov import AT_ONCE, CHANGED, FOUND, GOING, KEPT, ROUNDING, SIZE, STATE, Krylov
from particlecli.errors import SimulationError

FIRST_ORDER = {4: 0.2, 8: 1e-3}
"""By bytes of a number: what the last change δ of the accelerations k may be for a scheme of first order, in parts of
them: √(δ·Aδ / Σ m |k|²) with the matrix A of Newton's equations.

Times ½ h² a² both are energies: that of the last change, its stretch included, and that which a step of implicit Euler
takes from the motion by its own error, ½ Σ m |h k|². What the last change leaves over is taken too, by the next step:
in single precision up to a tenth of what the scheme takes anyway. Nothing smaller is asked for than what rounding of
positions is worth in the same measure.

A small change is the last if what it leaves of the equations themselves is as small, by r·z: where links of a long rope
turn far in a step, changes come out small by chance.
"""

HIGHER_ORDER = {4: 1e-2, 8: 1e-9}
"""The same for schemes of higher order, which take less or nothing."""

FORCING = (0.003, 0.05, 0.1)
"""Conjugate gradients end when r·z, which estimates the square of the error that is left in the norm of A, is the
square of this share of what has been found: in the first iteration of Newton's method, the second, and later ones;
those need not be closer than the last change may be large.

The first change takes back what the straight way that particles go by themselves stretches stiff springs, hundreds of
times what is looked for: of its error the next ones are full.
"""

RENEWED = 3
"""Iterations of Newton's method in which bodies are brought to the equations; for later ones they do as well."""

MOST_ITERATIONS, MOST_GRADIENTS = 50, 4000
"""Iterations of Newton's method, and of conjugate gradients in each, after which a step is cut in two."""

MOST_CUTS = 8
"""How often a step is cut in two before the run stops."""


class Newton:
    """Steps of a scheme whose stages are solved for one after the other, each from no acceleration.

    What was found in the step before is no better to begin with: what it leaves over in stiff springs would be
    extrapolated, and grow.

    Args:
        krylov: the kernels.
        stages: the scheme.
        prepare: gets forces ready at a time, s.
        revert: brings so many packs back to the beginning of the step.
        end: ends a step, given its start, now and length.
        order: of the scheme.
        real_bytes: size of a number.
    """

    def __init__(
        self,
        krylov: Krylov,
        stages: ImplicitStages,
        prepare: Callable[[float], None],
        revert: Callable[[int], None],
        end: Callable[[float, float, float], None],
        order: float,
        real_bytes: int,
    ) -> None:
        self._krylov, self._stages = krylov, stages
        self._prepare, self._revert, self._end = prepare, revert, end
        self._accuracy = (FIRST_ORDER if order == 1 else HIGHER_ORDER)[real_bytes]
        self._left = 0.0

    def compile(self) -> None:
        """Compile the kernels, by advancing nobody."""
        self._krylov.approach(0, 0, 0, 0, 0.0, 0.0, 1.0)
        self._krylov.evaluate(0, 0, 0.0)
        self._krylov.descend(0, 0, 1, 0, 0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0)

    def step(self, packs: int, start: float, now: float, h: float, cuts: int = 0) -> int:
        """A step of length h from `now`, s after `start`; returns how many evaluations it took.

        Raises:
            SimulationError: Newton's method does not converge, however short the step.
        """
        found, evaluations = self._solve(packs, start, now, h)
        if found:
            self._krylov.approach(self._stages.stages, 0, 0, packs, start, now, h)
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
        evaluations += self.step(packs, start, now, h / 2, cuts + 1)
        return evaluations + self.step(packs, start, now + h / 2, h / 2, cuts + 1)

    def _solve(self, packs: int, start: float, now: float, h: float) -> tuple[bool, int]:
        """Whether the stages of a step were found, and how many evaluations that took."""
        evaluations = self._stages.explicit
        for i in range(evaluations):
            self._krylov.approach(i, packs if i == 0 else 0, 0, packs, start, now, h)
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
        """Whether a stage was found, and how many evaluations that took."""
        factor, time = h * self._stages.own_weights[i], start + now + self._stages.times[i] * h
        numbers, smallest, enough = self._krylov.found.array, math.inf, -1.0
        self._krylov.approach(i, packs if i == 0 else 0, packs, packs, start, now, h)
        for iteration in range(MOST_ITERATIONS):
            self._prepare(time)
            forcing = max(FORCING[min(iteration, 2)], self._accuracy if iteration > 1 else 0.0)
            ended = self._descend(i, packs, int(iteration < RENEWED), forcing, enough, start + now, time, h, factor)
            if ended != CHANGED:
                return ended == KEPT, iteration + 1
            change, size = numbers[FOUND], numbers[SIZE]
            if not math.isfinite(change + size):
                return False, iteration + 1
            self._left = math.sqrt(change / size) if size > 0 else 0.0
            if change <= numbers[ROUNDING] / factor**4:
                return True, iteration + 1
            if not self._left < 1e3 * smallest:
                return False, iteration + 1
            enough = self._accuracy**2 * size if self._left <= self._accuracy else -1.0
            smallest = min(smallest, self._left)
        return False, MOST_ITERATIONS

    def _descend(self, i: int, packs: int, *rest: float) -> int:
        """An iteration of Newton's method: `Krylov.descend`, launched as often as that takes; how it ended."""
        state = GOING
        for launch in range(MOST_GRADIENTS // AT_ONCE):
            with self._krylov.team.working(packs) as members:
                self._krylov.descend(i, packs, members, int(launch > 0), *rest)
            state = int(self._krylov.found.array[STATE])
            if state != GOING:
                break
        return state

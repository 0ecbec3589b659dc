"""Steps of many coupled particles, stage by stage in a launch each."""

from collections.abc import Callable
from dataclasses import dataclass

from particlecli.dynamics.coupled.kernels import StageKernels
from particlecli.dynamics.integrators.adaptive import LARGEST_CHANGE, SAFETY, SMALLEST_CHANGE
from particlecli.dynamics.integrators.base import AdaptiveRungeKutta, AnyScheme
from particlecli.dynamics.paced import FIRST_STEP, SHORTEST_STEP
from particlecli.errors import SimulationError


@dataclass
class Pace:
    """How an adaptive scheme goes: the step it would like, s (0: not known yet), and the error of the last one."""

    liked: float = 0.0
    last: float = 1e-4


class LaunchedMarch:
    """Steps of equal length, or at the pace of the estimated error, by an explicit scheme.

    Args:
        kernels: the stages of a step.
        times: of its evaluations, in steps.
        scheme: the scheme.
        prepare: gets forces ready at a time, s.
    """

    def __init__(
        self, kernels: StageKernels, times: list[float], scheme: AnyScheme, prepare: Callable[[float], None]
    ) -> None:
        self._kernels, self._times, self._scheme, self._prepare = kernels, times, scheme, prepare
        self._eventful, self._reuses = kernels.step.eventful, kernels.step.reuses
        self._adaptive = isinstance(scheme, AdaptiveRungeKutta)

    def evenly(self, packs: int, start: float, interval: float, steps: int) -> None:
        """So many equal steps through an interval, s, from a time, s."""
        for s in range(steps):
            self._step(packs, start, s * interval / steps, interval / steps, again=s > 0)

    def _step(self, packs: int, start: float, now: float, h: float, *, again: bool) -> None:
        """A step of length h from `now`, s after `start`; `again`: it follows another one."""
        last = len(self._times) - 1
        for i, share in enumerate(self._times):
            known = again and self._reuses and i == 0
            if not known:
                self._prepare(start + now + share * h)
            ends = i == last and self._eventful and not self._adaptive
            counts = (packs if i == 0 else 0, 0 if known else packs, packs, packs if ends else 0)
            self._kernels.stage(i, *counts, start, now, h)

    def paced(
        self, packs: int, start: float, interval: float, longest: float, tolerance: float, pace: Pace
    ) -> tuple[int, int]:
        """Steps by the estimated error, up to so long, s, and so wrong; how many were taken and tried."""
        now, taken, tried = 0.0, 0, 0
        liked = pace.liked or FIRST_STEP * interval
        while now < interval:
            make_sure(liked >= SHORTEST_STEP * interval, start + now)
            left = interval - now
            h = min(liked, longest, left)
            h = left if left - h < 1e-9 * interval else h
            self._step(packs, start, now, h, again=False)
            error = float(self._kernels.error(packs, tolerance))
            tried += 1
            if error <= 1.0:
                if self._eventful:
                    self._kernels.end(packs, start, now, h)
                factor = self._change(error, pace.last)
                liked = max(liked, h * factor) if h < liked else h * factor
                pace.last = max(error, 1e-4)
                now = now + h if h < left else interval
                taken += 1
            else:
                self._kernels.revert(packs)
                liked = h * min(self._change(error, 1.0), 0.9)
        pace.liked = liked
        return taken, tried

    def _change(self, error: float, last: float) -> float:
        """As `AdaptiveStepper.change`, on the host."""
        assert isinstance(self._scheme, AdaptiveRungeKutta)
        factor: float = SAFETY * max(error, 1e-10) ** -self._scheme.exponent * last**self._scheme.memory
        return min(max(factor, SMALLEST_CHANGE), LARGEST_CHANGE)


def make_sure(possible: bool, time: float) -> None:
    """That an adaptive scheme can go on at a time, s."""
    if not possible:
        raise SimulationError(
            f"at t = {time:.9g} s the error can no longer be held within integrator.tolerance, however short the step: "
            "particles come so near each other that the force between them grows beyond all bounds. "
            "Give the force a softening, or end the scene before"
        )

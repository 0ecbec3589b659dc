"""When the particles of an emitter are born: exact instants, independent of steps and frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.random import Array
from particlecli.dynamics.rates import ConstantRate, Rate, VaryingRate
from particlecli.errors import Problem, SceneError, SimulationError
from particlecli.scene.groups import Burst, Emitter

Indices = NDArray[np.int64]

MOST_BIRTHS = 2_000_000_000
"""More births than this in one group are taken for a mistake in the scene."""

WINDOWS = 2**16
"""How many windows in time are looked at for the largest population."""

AGE_ERROR = 1e-6
"""Relative error of an age in single precision: a particle may outlive its lifetime by it."""


class BirthTimes:
    """The instants of birth in one emitter, in order; a particle's index is its place in this order.

    The k-th birth of the rate is when the integral of the rate reaches k + ½. Of births at the same instant
    those of the rate come first, then the bursts in the order of the scene. No table is kept: instants are
    worked out for the births that are asked for, each by itself.

    Attributes:
        total: number of births until the end, those at the very end included.

    Raises:
        SceneError: more than `MOST_BIRTHS` births.
        SimulationError: the rate is not finite at some time.
    """

    def __init__(self, name: str, emitter: Emitter, duration: float) -> None:
        self._rate = _rate(name, emitter, duration)
        bursts = [burst for burst in emitter.bursts if burst.time <= duration]
        bursts.sort(key=lambda burst: burst.time)
        _check_total(name, self._rate.total, sum(burst.count for burst in bursts))
        self._rate_births = int(self._rate.total + 0.5)
        self._place(bursts)
        self.total = self._rate_births + int(self._burst_births[-1])

    def _place(self, bursts: list[Burst]) -> None:
        self._burst_times = np.array([burst.time for burst in bursts])
        counts = np.array([burst.count for burst in bursts], np.int64)
        self._burst_births = np.concatenate(([0], np.cumsum(counts)))
        self._burst_start = self._rate_births_until(self._burst_times) + self._burst_births[:-1]
        self._burst_stop = self._burst_start + counts

    def until(self, times: Array) -> Indices:
        """Shape (n,): how many births there are up to each time, births at that very instant included."""
        bursts = np.searchsorted(self._burst_times, times, side="right")
        result: Indices = self._rate_births_until(times) + self._burst_births[bursts]
        return result

    def of(self, indices: Indices) -> Array:
        """Shape (n,), s: the instants of the births with these indices, from 0 to total − 1."""
        bursts = np.searchsorted(self._burst_start, indices, side="right")
        times = np.empty(len(indices))
        in_burst = indices < np.concatenate(([0], self._burst_stop))[bursts]
        times[in_burst] = self._burst_times[bursts[in_burst] - 1]
        of_rate = ~in_burst
        times[of_rate] = self._of_rate(indices[of_rate] - self._burst_births[bursts[of_rate]])
        return times

    def largest_population(self, longest_life: float | None, interval: float) -> int:
        """Most births within any span of `longest_life + interval`, s; all births where nobody dies of age.

        Never too small; too large by no more than one in `WINDOWS` of all births.
        """
        if longest_life is None or self.total == 0:
            return self.total
        every = -(-self.total // WINDOWS)
        first = np.arange(0, self.total, every)
        last = np.minimum(first + every, self.total) - 1
        span = longest_life * (1 + AGE_ERROR) + interval
        return int((self.until(self.of(last) + span) - first).max())

    def _of_rate(self, numbers: Indices) -> Array:
        return self._rate.instants(np.add(numbers, 0.5, dtype=np.float64))

    def _rate_births_until(self, times: Array) -> Indices:
        """The integral gives the number but for rounding; the instants of the births next to it decide."""
        if self._rate_births == 0:
            return np.zeros(len(times), np.int64)
        number = np.floor(self._rate.integral(times) + 0.5).astype(np.int64).clip(0, self._rate_births)
        last, following = np.maximum(number - 1, 0), np.minimum(number, self._rate_births - 1)
        too_many = (number > 0) & (self._of_rate(last) > times)
        too_few = (number < self._rate_births) & (self._of_rate(following) <= times)
        return number - too_many + too_few


def _rate(name: str, emitter: Emitter, duration: float) -> Rate:
    start = min(emitter.start, duration)
    stop = duration if emitter.stop is None else min(emitter.stop, duration)
    if emitter.rate is None or start >= stop:
        return ConstantRate(0.0, start, start)
    constant = emitter.rate.constant
    if constant is not None:
        return ConstantRate(max(constant, 0.0), start, stop)
    try:
        return VaryingRate(emitter.rate, start, stop)
    except SimulationError as error:
        raise SimulationError(f"emitter `{name}`: {error}") from None


def _check_total(name: str, rate_total: float, burst_total: int) -> None:
    expected = rate_total + burst_total
    if expected > MOST_BIRTHS:
        raise SceneError(
            [
                Problem(
                    f"emitters.{name}",
                    f"would give birth to {expected:,.10g} particles, more than the {MOST_BIRTHS:,} that a group can "
                    "have: lower its rate or its bursts",
                )
            ]
        )

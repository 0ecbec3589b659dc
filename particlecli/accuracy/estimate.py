"""The error of a run, estimated from a sample of its particles that is carried again in shorter steps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from particlecli.accuracy import prices
from particlecli.accuracy.bound import bound_samples
from particlecli.accuracy.families import child_samples
from particlecli.accuracy.samples import Sample
from particlecli.accuracy.tracks import Doubles, Ids, Mask, found
from particlecli.accuracy.trends import QUANTILE, Size, Trend, lost, size_of, trend_of, unit_of
from particlecli.frame import Curve
from particlecli.render.camera import on_picture

if TYPE_CHECKING:
    from particlecli.dynamics.rerun import Repeated
    from particlecli.frame import Frame
    from particlecli.render.camera import View
    from particlecli.simulate import Simulation

CHECKPOINTS, IN_ALL, AT_LEAST = 16, 64, 8
"""Frames at which a sample is compared, at most; of all groups together; and, where there are many groups, at least.
They are spread evenly, the last one among them."""


@dataclass(frozen=True)
class GroupError:
    """The estimated error of positions in a group.

    Attributes:
        metres: of the positions, m.
        pixels: on the picture, pixels; none if no particle of the sample is seen there.
        trend: whether solutions converge with the step.
        sampled, frames: particles and frames that were compared.
        alone: share of these at which a particle is alive in one of the two solutions alone.
        over_time: at each compared frame, of the positions, m; 95 in 100 are not larger.
    """

    metres: Size
    pixels: Size | None
    trend: Trend
    sampled: int
    frames: int
    alone: float
    over_time: Curve


class ErrorEstimate:
    """Watches a simulation, and in the end tells how wrong it was.

    A sample of each group is carried a second time at half the step, through the same kernels and in the
    memory of the group. For a scheme of order p the error of the run is 2^p/(2^p − 1) of the difference
    (Richardson). A part of the sample is carried at a quarter of the step: where that does not bring the solution
    nearer, the motion is chaotic at this step, and the estimate says so. Adaptive schemes get smaller tolerances
    instead of shorter steps. Which particles are looked at depends on the scene alone.

    Where that would cost more than `prices.SHARE` of the run, particles are carried at twice and four times the step
    instead, an eighth of the work: the error is 1/(2^p − 1) of the difference. Where that is too dear as well, nothing
    is told. Both costs are counted, so that the same scene always gives the same estimate.

    Args:
        simulation: not advanced yet.
        view_at: the camera that makes the picture, at each instant, s.
        besides: the price of what the run makes beside simulating.
        spent: price of other estimates, s.

    Attributes:
        left_out: in the end, groups of which an estimate would be too dear, also where it was begun and came to no end;
            and those that are too many together.
    """

    def __init__(
        self,
        simulation: Simulation,
        view_at: Callable[[float], View],
        besides: prices.Besides | None = None,
        spent: float = 0.0,
    ) -> None:
        self._simulation, self._view_at = simulation, view_at
        self._besides, self._spent, self._points = besides or prices.Besides(), spent, 0
        self.left_out: tuple[str, ...] = ()
        last = simulation.scene.frame_count - 1
        groups = max(1, len(simulation.system.groups))
        count = min(last, CHECKPOINTS, max(AT_LEAST, IN_ALL // groups))
        self._frames = [round(number * last / count) for number in range(1, count + 1)]
        self._samples = {
            name: Sample(group, simulation.system, len(self._frames))
            for name, group in simulation.system.groups.items()
            if group.plan.births.total and self._frames and not group.plan.coupled
        }
        self._samples |= bound_samples(simulation, self._frames)
        self._samples |= child_samples(simulation, self._frames)

    def watch(self, frame: Frame) -> None:
        """Note where the sample is at a frame."""
        self._points += sum(len(group.ids) for group in frame.groups.values())
        if frame.index in self._frames:
            place = self._frames.index(frame.index)
            for name, sample in self._samples.items():
                here, there = found(sample.ids, frame.groups[name].ids)
                sample.positions[place, here] = frame.groups[name].positions[there]

    def result(self) -> dict[str, GroupError]:
        """By group, the estimate; of a simulation at its end. Groups of which nothing was compared are left out."""
        self._budget()
        scene = self._simulation.scene
        times = np.array(self._frames) / scene.fps
        counts = np.diff([0, *self._frames]) * self._simulation.plan.steps_per_frame
        checkpoints = _Checkpoints(self._frames, times, counts, [self._view_at(time) for time in times.tolist()])
        estimates = {name: _compared(sample, checkpoints) for name, sample in self._samples.items()}
        self.left_out = tuple(name for name, sample in self._samples.items() if sample.carrier.comparison is None)
        self.left_out += self._too_many()
        return {name: estimate for name, estimate in estimates.items() if estimate is not None}

    def _too_many(self) -> tuple[str, ...]:
        """Groups of particles that act on each other of which there is no sample."""
        groups = self._simulation.system.groups.items() if self._frames else ()
        bound = (name for name, group in groups if group.plan.coupled and group.plan.births.total)
        return tuple(name for name in bound if name not in self._samples)

    def _budget(self) -> None:
        """Grant each sample its share, the cheapest ones first, which leave the others what they do not need."""
        system = self._simulation.system
        run = self._besides.fixed + self._points * self._besides.point + prices.simulated(system)
        left = prices.SHARE * run - self._spent
        carriers = list(dict.fromkeys(sample.carrier for sample in self._samples.values()))
        carriers.sort(key=lambda carrier: carrier.price(carrier.comparisons()[0]))
        for place, carrier in enumerate(carriers):
            left -= carrier.grant(left / (len(carriers) - place))


@dataclass(frozen=True)
class _Checkpoints:
    """The compared frames, their times, s, the steps from each to the next, and the camera there."""

    frames: Sequence[int]
    times: Doubles
    counts: Ids
    views: Sequence[View]


def _compared(sample: Sample, checkpoints: _Checkpoints) -> GroupError | None:
    times, counts = checkpoints.times, checkpoints.counts
    if sample.flies_straight:
        there = ~np.isnan(sample.positions[:, :, 0])
        return _error(sample, 0.5 * unit_of(sample), there, "rounding", checkpoints) if there.any() else None
    comparison = sample.carrier.comparison
    if comparison is None:
        return None
    other = sample.again(np.arange(len(sample.ids)), comparison.refinement, times, counts)
    if not other.complete or (comparison.refinement < 0 and _fails(other, sample)):
        sample.carrier.comparison = None
        return None
    distance = np.linalg.norm(sample.positions - other.positions, axis=2)
    both = ~np.isnan(distance)
    if not both.any():
        return None
    share, trend = trend_of(sample, comparison, other, distance, times, counts)
    stuck = lost(sample, other, times, counts)
    length = np.maximum(np.maximum(share * distance, stuck), 0.5 * unit_of(sample))
    if (stuck[both] > share * distance[both]).mean() > 1.0 - QUANTILE:
        trend = "rounding"
    either = ~(np.isnan(sample.positions[:, :, 0]) & np.isnan(other.positions[:, :, 0]))
    return _error(sample, length, either, trend, checkpoints)


def _fails(other: Repeated, sample: Sample) -> bool:
    """Whether another solution does not come to the end: its steps are too long."""
    there = ~np.isnan(sample.positions[-1, :, 0])
    return bool(there.any() and np.isnan(other.positions[-1, there, 0]).all())


def _error(sample: Sample, length: Doubles, either: Mask, trend: Trend, checkpoints: _Checkpoints) -> GroupError:
    """The estimate from the error of each particle, m, and where it is alive in one of the solutions.

    On the picture it may point anywhere; it counts as long as it would be across the line of sight.
    """
    compared = ~np.isnan(length)
    seen = np.stack(
        [
            on_picture(places, off[:, None] * view.right, view)
            for places, off, view in zip(sample.positions, length, checkpoints.views, strict=True)
        ]
    )
    return GroupError(
        metres=size_of(length[compared]),
        pixels=None if np.isnan(seen).all() else size_of(seen[~np.isnan(seen)]),
        trend=trend,
        sampled=len(sample.ids),
        frames=len(length),
        alone=1.0 - float(compared.sum() / either.sum()),
        over_time=_over_time(length, compared, checkpoints),
    )


def _over_time(length: Doubles, compared: Mask, checkpoints: _Checkpoints) -> Curve:
    rows = np.flatnonzero(compared.any(axis=1)).tolist()
    return Curve(
        frames=tuple(checkpoints.frames[row] for row in rows),
        times=tuple(checkpoints.times[rows].tolist()),
        values=tuple(size_of(length[row, compared[row]]).p95 for row in rows),
    )

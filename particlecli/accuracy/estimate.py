"""The error of a run, estimated from a sample of its particles that is carried again in shorter steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from particlecli.accuracy.families import child_samples
from particlecli.accuracy.samples import QUARTER, Sample, bound_samples
from particlecli.accuracy.tracks import Doubles, Ids, Mask, found
from particlecli.frame import Curve
from particlecli.render.camera import on_picture

if TYPE_CHECKING:
    from particlecli.dynamics.group import Group
    from particlecli.dynamics.rerun import Repeated
    from particlecli.frame import Frame
    from particlecli.render.camera import View
    from particlecli.simulate import Simulation

CHECKPOINTS, IN_ALL, AT_LEAST = 16, 64, 8
"""Frames at which a sample is compared, at most; of all groups together; and, where there are many groups, at least.
They are spread evenly, the last one among them."""

NEARER = 0.7
"""Solutions converge if each is nearer to the next one than this share of the distance before."""

FAR, HIGHEST = 0.01, 4.0
"""Solutions further apart than this share of how far particles go are chaotic, unless halving the step gains half the
orders of magnitude it should; for that no order counts as more than the second number."""

ROUNDINGS = 10.0
"""Roundings of the coordinates, times the square root of the number of steps, that are called rounding."""

QUANTILE = 0.95

SQRT3 = math.sqrt(3.0)
"""Two solutions, one of twice as many roundings, are √3 times as far apart as one of them is off."""

Trend = Literal["converging", "rounding", "irregular", "chaotic", "unchecked"]
"""What happens to the solution as steps get shorter: it settles as it should; rounding is all that changes; it settles,
but not as it should, so that the estimate is rough; it does not settle. Or that was not looked at."""


@dataclass(frozen=True)
class Size:
    """Errors of the sampled particles at the compared frames.

    Attributes:
        p95: 95 in 100 are not larger.
        largest: of all.
    """

    p95: float
    largest: float


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

    Args:
        simulation: not advanced yet.
        view_at: the camera that makes the picture, at each instant, s.
    """

    def __init__(self, simulation: Simulation, view_at: Callable[[float], View]) -> None:
        self._simulation, self._view_at = simulation, view_at
        last = simulation.scene.frame_count - 1
        groups = max(1, len(simulation.system.groups))
        count = min(last, CHECKPOINTS, max(AT_LEAST, IN_ALL // groups))
        self._frames = [round(number * last / count) for number in range(1, count + 1)]
        self._samples = {
            name: Sample(group, len(self._frames), simulation.plan.steps_per_frame * last)
            for name, group in simulation.system.groups.items()
            if group.plan.births.total and self._frames and not group.plan.coupled
        }
        self._samples |= bound_samples(simulation, self._frames)
        self._samples |= child_samples(simulation, self._frames)

    def watch(self, frame: Frame) -> None:
        """Note where the sample is at a frame."""
        if frame.index in self._frames:
            place = self._frames.index(frame.index)
            for name, sample in self._samples.items():
                here, there = found(sample.ids, frame.groups[name].ids)
                sample.positions[place, here] = frame.groups[name].positions[there]

    def result(self) -> dict[str, GroupError]:
        """By group, the estimate; of a simulation at its end. Groups of which nothing was compared are left out."""
        scene = self._simulation.scene
        times = np.array(self._frames) / scene.fps
        counts = np.diff([0, *self._frames]) * self._simulation.plan.steps_per_frame
        checkpoints = _Checkpoints(self._frames, times, counts, [self._view_at(time) for time in times.tolist()])
        estimates = {name: _compared(sample, checkpoints) for name, sample in self._samples.items()}
        return {name: estimate for name, estimate in estimates.items() if estimate is not None}


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
        return _error(sample, 0.5 * _unit(sample), there, "rounding", checkpoints) if there.any() else None
    other = sample.again(np.arange(len(sample.ids)), -1 if sample.heavy else 1, times, counts)
    distance = np.linalg.norm(sample.positions - other.positions, axis=2)
    both = ~np.isnan(distance)
    if not both.any():
        return None
    share, trend = _trend(sample, other, distance, times, counts)
    stuck = _stuck(sample, other, times, counts)
    length = np.maximum(np.maximum(share * distance, stuck), 0.5 * _unit(sample))
    if (stuck[both] > share * distance[both]).mean() > 1.0 - QUANTILE:
        trend = "rounding"
    either = ~(np.isnan(sample.positions[:, :, 0]) & np.isnan(other.positions[:, :, 0]))
    return _error(sample, length, either, trend, checkpoints)


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
        metres=_size(length[compared]),
        pixels=None if np.isnan(seen).all() else _size(seen[~np.isnan(seen)]),
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
        values=tuple(_size(length[row, compared[row]]).p95 for row in rows),
    )


def _trend(sample: Sample, other: Repeated, distance: Doubles, times: Doubles, counts: Ids) -> tuple[float, Trend]:
    """What the distance between two solutions has to be multiplied by to get the error, and what they tend to."""
    order = _order(sample.group)
    if sample.heavy:
        return 1.0 / (2.0**order - 1.0), "unchecked"
    if sample.once:
        return 1.0 / (1.0 - 2.0**-order), "unchecked"
    places, some = sample.checked, np.arange(len(times))[::-QUARTER][::-1]
    finest = sample.again(places, 2, times[some], np.diff([0, *np.cumsum(counts)[some]]))
    distances = distance[some][:, places]
    rests = np.linalg.norm(other.positions[some][:, places] - finest.positions, axis=2)
    common = ~(np.isnan(rests) | np.isnan(distances))
    declared = 1.0 / (1.0 - 2.0**-order)
    if not common.any():
        return declared, "unchecked"
    first, second = _size(distances[common]).p95, _size(rests[common]).p95
    reach = float(np.nanquantile(np.linalg.norm(sample.positions - sample.births.positions.T, axis=2), QUANTILE))
    if first > FAR * reach and second > first / 2.0 ** (0.5 * min(order, HIGHEST)):
        return 2.0, "chaotic"
    if second <= NEARER * first and first > 0.0:
        return max(declared, first / (first - second)), "converging"
    return (1.0 / SQRT3, "rounding") if first <= _rounding(sample, counts) else (2.0, "irregular")


def _order(group: Group) -> float:
    """With which power of the step the error falls; that of an adaptive scheme vanishes with the tolerance."""
    if group.plan.adaptive:
        return math.inf
    simple = bool(group.plan.planes) and group.plan.contact == "end_of_step"
    return 1 if simple else group.plan.scheme.order


def _unit(sample: Sample) -> Doubles:
    """The rounding of the largest coordinate of each particle at each frame, m, shape (frames, n)."""
    largest = np.abs(sample.positions).max(axis=2)
    if sample.group.plan.real_bytes == 4:
        return np.asarray(np.spacing(largest.astype(np.float32))).astype(np.float64)
    return np.asarray(np.spacing(largest))


def _rounding(sample: Sample, counts: Ids) -> float:
    """A distance that rounding alone explains, m."""
    return ROUNDINGS * float(np.nanquantile(_unit(sample), 0.95)) * math.sqrt(float(counts.sum()))


def _stuck(sample: Sample, other: Repeated, times: Doubles, counts: Ids) -> Doubles:
    """How far particles may be behind because steps vanish in the rounding of large coordinates, m.

    Shape (frames, n). All solutions lose these alike, so that comparing them does not tell.
    """
    unit = np.nan_to_num(_unit(sample))
    spans = np.diff([0.0, *times])[:, None]
    steps = counts[:, None]
    lost = (other.speeds > 0) & (other.speeds * spans < 4.0 * unit * steps)
    return np.cumsum(np.where(lost, np.minimum(0.5 * unit * steps, other.speeds * spans), 0.0), axis=0)


def _size(values: Doubles) -> Size:
    return Size(float(np.quantile(values, QUANTILE, method="inverted_cdf")), float(values.max()))

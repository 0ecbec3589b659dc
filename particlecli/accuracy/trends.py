"""Whether solutions of shorter and shorter steps settle, and what their distance tells of the error."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from particlecli.accuracy.samples import QUARTER, Comparison, Sample
from particlecli.accuracy.tracks import Doubles, Ids

if TYPE_CHECKING:
    from particlecli.dynamics.group import Group
    from particlecli.dynamics.rerun import Repeated

NEARER = 0.7
"""Solutions converge if each is nearer to the next one than this share of the distance before."""

FAR, HIGHEST = 0.01, 4.0
"""Solutions further apart than this share of how far particles go are chaotic, unless halving the step gains half the
orders of magnitude it should; for that no order counts as more than the second number."""

ROUNDINGS = 10.0
"""Roundings of the coordinates, times the square root of the number of steps, that are called rounding."""

QUANTILE = 0.95

SQRT3, SQRT3_2 = math.sqrt(3.0), math.sqrt(1.5)
"""Two solutions, one of twice as many roundings, are √3 times as far apart as the one of fewer is off, and √1.5 times
as far as the other."""

Trend = Literal["converging", "rounding", "irregular", "chaotic", "unsettled", "unchecked"]
"""What happens to the solution as steps get shorter: it settles as it should; rounding is all that changes; it settles,
but not as it should, so that the estimate is rough; it does not settle; with longer steps alone it does not, so that
nothing is known. Or that was not looked at."""


@dataclass(frozen=True)
class Size:
    """Errors of the sampled particles at the compared frames.

    Attributes:
        p95: 95 in 100 are not larger.
        largest: of all.
    """

    p95: float
    largest: float


def trend_of(
    sample: Sample, comparison: Comparison, other: Repeated, distance: Doubles, times: Doubles, counts: Ids
) -> tuple[float, Trend]:
    """What the distance between two solutions has to be multiplied by to get the error, and what they tend to."""
    order, finer = _order(sample.group), comparison.refinement > 0
    ratio = sample.ratio(comparison.refinement, counts)
    gain = ratio**order
    declared = 1.0 / (1.0 - 1.0 / gain) if finer else 1.0 / (gain - 1.0)
    if comparison.check is None:
        return declared, "unchecked"
    places, some = sample.checked, np.arange(len(times))[::-QUARTER][::-1]
    third = sample.again(places, comparison.check, times[some], np.diff([0, *np.cumsum(counts)[some]]))
    distances = distance[some][:, places]
    rests = np.linalg.norm(other.positions[some][:, places] - third.positions, axis=2)
    common = ~(np.isnan(rests) | np.isnan(distances))
    if not third.complete or not common.any():
        return declared, "unchecked"
    first, second = size_of(distances[common]).p95, size_of(rests[common]).p95
    longer, shorter = (first, second) if finer else (second, first)
    there = np.linalg.norm(sample.positions - sample.births.positions.T, axis=2)
    reach = size_of(there[~np.isnan(there)]).p95
    if first > FAR * reach and shorter > longer / 2.0 ** (0.5 * min(order, HIGHEST)):
        return 2.0, "chaotic" if finer else "unsettled"
    if shorter <= NEARER * longer and longer > 0.0:
        # Impacts at the ends of steps are of first order; where few meet planes, longer steps tell the scheme's own.
        least = declared if finer else 1.0 / (ratio**sample.group.plan.scheme.order - 1.0)
        return max(least, first / (longer - shorter)), "converging"
    rounding = first <= _rounding(sample, counts)
    return (1.0 / (SQRT3 if finer else SQRT3_2), "rounding") if rounding else (2.0, "irregular")


def _order(group: Group) -> float:
    """With which power of the step the error falls; that of an adaptive scheme vanishes with the tolerance."""
    if group.plan.adaptive:
        return math.inf
    simple = bool(group.plan.planes) and group.plan.contact == "end_of_step"
    return 1 if simple else group.plan.scheme.order


def unit_of(sample: Sample) -> Doubles:
    """The rounding of the largest coordinate of each particle at each frame, m, shape (frames, n)."""
    largest = np.abs(sample.positions).max(axis=2)
    if sample.group.plan.real_bytes == 4:
        return np.asarray(np.spacing(largest.astype(np.float32))).astype(np.float64)
    return np.asarray(np.spacing(largest))


def _rounding(sample: Sample, counts: Ids) -> float:
    """A distance that rounding alone explains, m."""
    unit = unit_of(sample)
    return ROUNDINGS * size_of(unit[~np.isnan(unit)]).p95 * math.sqrt(float(counts.sum()))


def lost(sample: Sample, other: Repeated, times: Doubles, counts: Ids) -> Doubles:
    """How far particles may be behind because steps vanish in the rounding of large coordinates, m.

    Shape (frames, n). All solutions lose these alike, so that comparing them does not tell.
    """
    unit = np.nan_to_num(unit_of(sample))
    spans = np.diff([0.0, *times])[:, None]
    steps = counts[:, None]
    vanish = (other.speeds > 0) & (other.speeds * spans < 4.0 * unit * steps)
    return np.cumsum(np.where(vanish, np.minimum(0.5 * unit * steps, other.speeds * spans), 0.0), axis=0)


def size_of(values: Doubles) -> Size:
    """The size of errors, one at least, of any shape."""
    place = math.ceil(QUANTILE * values.size) - 1  # np.quantile would import half of NumPy first
    return Size(float(np.partition(values.ravel(), place)[place]), float(values.max()))

"""Whether two recordings agree, and where they part."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from particlecli.sinks.recording.reader import Points, Recording, Series

COUNTED = ("alive", "deaths")
"""Plots of whole numbers, which do not follow from positions alone."""


@dataclass(frozen=True)
class Parting:
    """Where two recordings part first, in one respect.

    Attributes:
        what: a group, or a series.
        frame: the first frame that differs; none where one of them does not have it at all.
        time: s.
        how: in words.
    """

    what: str
    frame: int | None
    time: float | None
    how: str


@dataclass(frozen=True)
class Difference:
    """What two recordings differ in.

    Attributes:
        partings: in which respects, the earliest first; empty when they agree.
        largest: the largest distance, m, between a particle and the same one at the same frame of the other.
    """

    partings: tuple[Parting, ...]
    largest: float

    @property
    def agree(self) -> bool:
        """Whether they agree."""
        return not self.partings


def difference(ours: Recording, theirs: Recording, tolerance: float = 0.0) -> Difference:
    """Compares two recordings: groups, frames, particles, positions and series.

    Args:
        ours, theirs: the recordings.
        tolerance: the largest distance, m, at which positions still agree. Above 0, series of energy and the
            like are not compared; those that count something always are.
    """
    partings: list[Parting] = []
    largest = 0.0
    for group in dict.fromkeys((*ours.groups, *theirs.groups)):
        missing = _missing(group, group in ours.groups, group in theirs.groups)
        if missing:
            partings.append(missing)
            continue
        parting, distance = _compare(ours.points(group), theirs.points(group), tolerance)
        largest = max(largest, distance)
        partings += [parting] if parting else []
    for name in dict.fromkeys((*ours.series, *theirs.series)):
        if tolerance == 0 or name.split("/")[0] in COUNTED:
            parting = _missing(name, name in ours.series, name in theirs.series)
            parting = parting or _compare_series(name, ours.series[name], theirs.series[name])
            partings += [parting] if parting else []
    return Difference(tuple(sorted(partings, key=lambda each: -1 if each.frame is None else each.frame)), largest)


def _missing(name: str, is_ours: bool, is_theirs: bool) -> Parting | None:
    if is_ours and is_theirs:
        return None
    return Parting(name, None, None, f"only in the {'first' if is_ours else 'second'}")


def _compare(ours: Iterator[Points], theirs: Iterator[Points], tolerance: float) -> tuple[Parting | None, float]:
    """The first parting of a group, and the largest distance over all frames that both have."""
    first: Parting | None = None
    largest = 0.0
    for mine, yours in zip_longest(ours, theirs):
        here = mine or yours
        if mine is None or yours is None or mine.frame != yours.frame:
            frames = [f"{each.frame}" if each else "none" for each in (mine, yours)]
            how = f"the next recorded frame is {frames[0]} in the first and {frames[1]} in the second"
            return first or Parting(here.group, here.frame, here.time, how), largest
        how, distance = _compare_points(mine, yours, tolerance)
        largest = max(largest, distance)
        if how and first is None:
            first = Parting(mine.group, mine.frame, mine.time, how)
    return first, largest


def _compare_points(mine: Points, yours: Points, tolerance: float) -> tuple[str, float]:
    """How the points of a group differ at a frame, and the largest distance between the same particles."""
    if np.array_equal(mine.ids, yours.ids):
        common, here, there = mine.ids, mine.positions, yours.positions
    else:
        common, mine_at, yours_at = np.intersect1d(mine.ids, yours.ids, assume_unique=True, return_indices=True)
        here, there = mine.positions[mine_at], yours.positions[yours_at]
    distances = np.linalg.norm(here.astype(np.float64) - there, axis=1)
    largest = float(distances.max(initial=0.0))
    alone = [len(each.ids) - len(common) for each in (mine, yours)]
    if any(alone):
        return f"{alone[0]:,} particles are only in the first, {alone[1]:,} only in the second", largest
    if largest > tolerance or math.isnan(largest):
        count = int(np.count_nonzero(~(distances <= tolerance)))
        return (
            f"particle {common[distances.argmax()]} is {largest:.3g} m apart ({count:,} of {len(common):,} differ)",
            largest,
        )
    return "", largest


def _compare_series(name: str, ours: Series, theirs: Series) -> Parting | None:
    count = min(len(ours.values), len(theirs.values))
    same = (ours.frames[:count] == theirs.frames[:count]) & (ours.values[:count] == theirs.values[:count])
    places = np.flatnonzero(~same)
    if len(places):
        at = int(places[0])
        how = f"{ours.values[at]:.10g} in the first, {theirs.values[at]:.10g} in the second"
        return Parting(name, int(ours.frames[at]), float(ours.times[at]), how)
    if len(ours.values) == len(theirs.values):
        return None
    longer = ours if len(ours.values) > count else theirs
    which = "first" if longer is ours else "second"
    return Parting(name, int(longer.frames[count]), float(longer.times[count]), f"only the {which} goes on")

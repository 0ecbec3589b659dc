"""Recordings that agree, and where others part."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from particlecli.frame import Frame
from particlecli.sinks.recording.difference import Difference, difference
from particlecli.sinks.recording.reader import Recording
from tests.sinks.recording.conftest import Record


def between(ours: Path, theirs: Path, tolerance: float = 0.0) -> Difference:
    with Recording(ours) as first, Recording(theirs) as second:
        return difference(first, second, tolerance)


def moved(frame: Frame, group: str, place: int, distance: float) -> Frame:
    positions = frame.groups[group].positions.copy()
    positions[place] += np.array([0, 0, distance], positions.dtype)
    return replace(frame, groups={**frame.groups, group: replace(frame.groups[group], positions=positions)})


def test_the_same_frames_agree(record: Record, frames: list[Frame]) -> None:
    found = between(record("a.rrd", frames), record("b.rrd", frames))
    assert found.agree
    assert found.largest == 0


def test_a_particle_elsewhere_is_named(record: Record, frames: list[Frame]) -> None:
    others = [*frames[:2], moved(frames[2], "sparks", 1, 0.25), moved(frames[3], "sparks", 0, 0.5)]
    ours, theirs = record("a.rrd", frames), record("b.rrd", others)
    found = between(ours, theirs)
    (parting,) = found.partings
    assert (parting.what, parting.frame) == ("sparks", 2)
    assert parting.time == pytest.approx(2 / 30)
    assert parting.how == "particle 3 is 0.25 m apart (1 of 3 differ)"
    assert found.largest == pytest.approx(0.5, rel=1e-6)
    assert between(ours, theirs, tolerance=0.3).partings[0].frame == 3
    assert between(ours, theirs, tolerance=0.6).agree


def test_a_particle_nowhere_is_a_difference(record: Record, frames: list[Frame]) -> None:
    others = [moved(frames[0], "dust", 7, np.nan), *frames[1:]]
    (parting,) = between(record("a.rrd", frames), record("b.rrd", others), tolerance=1.0).partings
    assert (parting.what, parting.frame) == ("dust", 0)


def test_other_particles_and_fewer_frames(record: Record, frames: list[Frame]) -> None:
    sparks = frames[1].groups["sparks"]
    others = [frames[0], replace(frames[1], groups={**frames[1].groups, "sparks": replace(sparks, ids=sparks.ids + 1)})]
    found = between(record("a.rrd", frames), record("b.rrd", others))
    ways = {parting.what: (parting.frame, parting.how) for parting in found.partings}
    assert ways["sparks"] == (1, "1 particles are only in the first, 1 only in the second")
    assert ways["dust"] == (2, "the next recorded frame is 2 in the first and none in the second")
    assert ways["energy/kinetic"] == (2, "only the first goes on")
    assert [parting.frame for parting in found.partings] == sorted(parting.frame for parting in found.partings)


def test_series_are_compared_too(record: Record, frames: list[Frame]) -> None:
    energy, deaths = ([replace(frames[0], series={**frames[0].series, **each})] for each in (
        {"energy": {"kinetic": 1e-9}}, {"deaths": {"sparks/expired": 1.0}}
    ))  # fmt: skip
    first = record("a.rrd", frames[:1])
    second, third = record("b.rrd", energy), record("c.rrd", deaths)
    assert [parting.what for parting in between(first, second).partings] == ["energy/kinetic"]
    assert between(first, second, tolerance=1e-6).agree
    assert [parting.what for parting in between(first, third, tolerance=1.0).partings] == ["deaths/sparks/expired"]


def test_thinning_that_keeps_all_changes_nothing(record: Record, frames: list[Frame]) -> None:
    thinned = record("b.rrd", frames[:1], max_points=103)
    assert between(record("a.rrd", frames[:1]), thinned).agree

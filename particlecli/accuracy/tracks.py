"""Where chosen particles are at every frame, and how far one such record is from another."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from particlecli.render.camera import View, on_picture

if TYPE_CHECKING:
    from particlecli.dynamics.system import System
    from particlecli.frame import GroupFrame

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Track:
    """Some particles of one group at every frame; NaN at frames at which a particle is not alive.

    Attributes:
        ids: numbers of the particles, shape (n,).
        positions: shape (frames, n, 3), m.
        velocities: shape (frames, n, 3), m/s; None in a first-order group.
    """

    ids: Ids
    positions: Doubles
    velocities: Doubles | None

    @classmethod
    def empty(cls, ids: Ids, frames: int, *, newtonian: bool) -> Track:
        """A record into which nothing has been written yet."""
        shape = (frames, len(ids), 3)
        return cls(ids, np.full(shape, np.nan), np.full(shape, np.nan) if newtonian else None)

    def write(self, index: int, group: GroupFrame) -> None:
        """Note where the particles are at a frame."""
        here, there = found(self.ids, group.ids)
        self.positions[index, here] = group.positions[there]
        if self.velocities is not None and group.velocities is not None:
            self.velocities[index, here] = group.velocities[there]

    def of(self, places: Ids) -> Track:
        """That of some of the particles."""
        velocities = None if self.velocities is None else self.velocities[:, places]
        return Track(self.ids[places], self.positions[:, places], velocities)

    @property
    def alive(self) -> NDArray[np.bool_]:
        """Whether each particle is alive at each frame, shape (frames, n)."""
        return ~np.isnan(self.positions[:, :, 0])


Tracks = dict[str, Track]
"""By group."""


def found(wanted: Ids, present: Ids) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Which of the wanted numbers are present, shape (n,), and where those are; both lists in order."""
    places = np.searchsorted(present, wanted)
    inside = places < len(present)
    there = inside.copy()
    there[inside] = present[places[inside]] == wanted[inside]
    return there, places[there]


def follow(system: System, ids: Mapping[str, Ids]) -> tuple[Tracks, float]:
    """Run a system from t = 0 to the end of its scene; returns the record and the wall time of advancing, s.

    Raises:
        SimulationError: it did not reach the end.
    """
    scene = system.plan.scene
    tracks = {
        group.name: Track.empty(ids[group.name], scene.frame_count, newtonian=group.newtonian)
        for group in system.plan.groups
    }
    fields = dict.fromkeys(tracks, frozenset({"velocities"}))
    system.restart()
    seconds = 0.0
    for index in range(scene.frame_count):
        began = time.perf_counter()
        system.advance(index / scene.fps)
        seconds += time.perf_counter() - began
        frame = system.frame(index, fields)
        for name, track in tracks.items():
            track.write(index, frame.groups[name])
    return tracks, seconds


@dataclass(frozen=True)
class Spread:
    """Distances of many particles at one frame, or the largest of each over several frames.

    Attributes:
        rms: root mean square.
        p95: 95 in 100 particles are at most this far off; of fewer than 20 it is the largest.
        largest: of all.
    """

    rms: float
    p95: float
    largest: float


@dataclass(frozen=True)
class Deviation:
    """How far particles are from a reference; of several groups, the group that is furthest off.

    Attributes:
        final: in metres, at the last frame at which there is something to compare.
        worst: in metres, the largest over all frames.
        final_pixels, worst_pixels: the same on the scene's picture, of particles seen on it; none if none is.
        unmatched: share of particles and frames at which a particle is alive in one of the two alone.
    """

    final: Spread
    worst: Spread
    final_pixels: Spread | None
    worst_pixels: Spread | None
    unmatched: float


def deviation(tracks: Tracks, reference: Tracks, view: View) -> Deviation:
    """How far the particles of a record are from where they are in a reference.

    Raises:
        ValueError: there is nothing to compare.
    """
    metres, pixels = [], []
    common = either = 0
    for name, right in reference.items():
        offset = tracks[name].positions - right.positions
        metres.append(np.sqrt((offset**2).sum(axis=2)))
        pixels.append(on_picture(right.positions, offset, view))
        common += int((tracks[name].alive & right.alive).sum())
        either += int((tracks[name].alive | right.alive).sum())
    final, worst = _furthest(metres)
    if final is None or worst is None:
        raise ValueError("no particle is alive in both at any frame")
    return Deviation(final, worst, *_furthest(pixels), 1.0 - common / either)


def _furthest(groups: Iterable[Doubles]) -> tuple[Spread | None, Spread | None]:
    """The last and the largest spread over frames; of groups of shape (frames, n) each time the largest."""
    by_frame = [spread_by_frame(distances) for distances in groups]
    there = [spreads[~np.isnan(spreads[:, 0])] for spreads in by_frame]
    some = [spreads for spreads in there if len(spreads)]
    if not some:
        return None, None
    final = np.max([spreads[-1] for spreads in some], axis=0)
    worst = np.max([spreads.max(axis=0) for spreads in some], axis=0)
    return Spread(*final.tolist()), Spread(*worst.tolist())


def spread_by_frame(distances: Doubles) -> Doubles:
    """The numbers of `Spread` of each frame, shape (frames, 3), from shape (frames, n); NaN where none is."""
    frames, most = distances.shape
    result = np.full((frames, 3), np.nan)
    if most == 0:
        return result
    count = (~np.isnan(distances)).sum(axis=1)
    ordered = np.sort(distances, axis=1)  # NaN comes last
    rows = np.flatnonzero(count)
    rank = np.ceil(0.95 * count[rows]).astype(np.int64) - 1
    result[rows, 0] = np.sqrt(np.nansum(distances[rows] ** 2, axis=1) / count[rows])
    result[rows, 1] = ordered[rows, rank]
    result[rows, 2] = ordered[rows, count[rows] - 1]
    return result

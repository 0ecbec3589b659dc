"""A solution to measure others by, converged in double precision, and a second one that tells how sure it is."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from particlecli.accuracy.tracks import Deviation, Track, Tracks, deviation
from particlecli.accuracy.trial import Pace, Trial
from particlecli.dynamics.integrators import SCHEMES
from particlecli.errors import SimulationError
from particlecli.render.camera import View
from particlecli.scene.integrator import Scheme

TOLERANCE = 1e-13
"""Of the adaptive solution."""

FIRST_STEPS = 4
"""Steps a frame that the second solution begins with; they are doubled as long as that brings it nearer."""

MOST_STEPS = 1 << 20
"""Steps a frame after which no more are tried."""

NO_NEARER = 0.7
"""A second solution that comes no nearer than to this share of the distance before has converged."""

ASYMPTOTIC = 1e-3
"""Solutions that are this near each other, in parts of how far particles go, converge steadily."""

SECOND: tuple[Scheme, ...] = ("composition8", "rk4", "radau_iia")
"""Schemes for the second solution, the first suitable one that reaches the end."""


@dataclass(frozen=True)
class Reference:
    """A solution that others are measured by.

    Attributes:
        tracks: where the particles are.
        method, second: in words, how it and the solution it was compared with were computed.
        uncertainty: how far the two are apart; the reference is about as near to the truth, or nearer.
        extent: how far particles go, m; 95 in 100 stay below.
    """

    tracks: Tracks
    method: str
    second: str
    uncertainty: Deviation
    extent: float


MakeTrial = Callable[[Scheme], Trial]
"""Builds the trial of a scheme, in double precision."""


@dataclass(frozen=True)
class _Solution:
    tracks: Tracks
    method: str


def converged(make: MakeTrial, schemes: Sequence[Scheme], view: View, longest: float) -> Reference:
    """The most accurate solution that can be had, and how sure it is.

    It is the closed form where the scene has one, else an adaptive solution of order 8. The second one is of
    another kind, in steps that are halved until it comes no nearer.

    Args:
        make: builds trials.
        schemes: those that can run the scene.
        view: the scene's camera.
        longest: wall time that one run may take, about, s.

    Raises:
        SimulationError: there are no two solutions to compare.
    """
    best = _best(make, schemes)
    for scheme in SECOND:
        if scheme in schemes:
            reference = _compared(best, _refined(make(scheme), scheme, longest), view)
            if reference is not None:
                return reference
    raise SimulationError("no two integrators reach the end of the scene, so there is nothing to measure errors by")


def _best(make: MakeTrial, schemes: Sequence[Scheme]) -> _Solution | None:
    """The closed form, else the adaptive solution, if either reaches the end."""
    try:
        if "exact" in schemes:
            return _Solution(make("exact").run(Pace(steps=1)).tracks, "exact, the closed form")
        tracks = make("dop853").run(Pace(tolerance=TOLERANCE)).tracks
        return _Solution(tracks, f"dop853, tolerance {TOLERANCE:g}")
    except SimulationError:
        return None


def _refined(trial: Trial, scheme: Scheme, longest: float) -> Iterator[_Solution]:
    """Solutions with ever more steps, as long as a run takes no longer than `longest`, s.

    From the second on each is extrapolated from two runs to steps of no length, as their order foretells.
    """
    steps, seconds, before = FIRST_STEPS, 0.0, None
    while 2 * seconds <= longest and steps <= MOST_STEPS:
        with suppress(SimulationError):
            outcome = trial.run(Pace(steps=steps))
            seconds = outcome.seconds
            if before is None:
                yield _Solution(outcome.tracks, f"{scheme}, {steps} steps a frame")
            else:
                tracks = _extrapolated(before, outcome.tracks, 2.0 ** SCHEMES[scheme].order)
                yield _Solution(tracks, f"{scheme}, extrapolated from {steps // 2} and {steps} steps a frame")
            before = outcome.tracks
        steps *= 2


def _extrapolated(coarse: Tracks, fine: Tracks, factor: float) -> Tracks:
    """What the tracks tend to whose errors are `factor` times as small each time the steps are halved."""
    return {name: _beyond(coarse[name], track, 1.0 / (factor - 1.0)) for name, track in fine.items()}


def _beyond(coarse: Track, fine: Track, share: float) -> Track:
    gained = fine.positions - coarse.positions
    return Track(fine.ids, fine.positions + share * np.where(np.isnan(gained), 0.0, gained), None)


def _compared(best: _Solution | None, others: Iterator[_Solution], view: View) -> Reference | None:
    """The reference and the nearest of the others; where there is no best one, the nearest two in a row."""
    reference, last, stalled = None, best, 0
    for other in others:
        if last is not None:
            apart = deviation(other.tracks, last.tracks, view)
            first, second = (best, other) if best else (other, last)
            limit = math.inf if reference is None else reference.uncertainty.worst.p95
            if apart.worst.p95 < limit:
                reference = Reference(first.tracks, first.method, second.method, apart, extent(first.tracks))
            near = apart.worst.p95 <= ASYMPTOTIC * extent(first.tracks)
            stalled = stalled + 1 if near and apart.worst.p95 > NO_NEARER * limit else 0
        last = best or other
        if stalled == 2:
            break
    return reference


def extent(tracks: Tracks) -> float:
    """How far particles go from where they are first seen, m: of the group that goes furthest, 95 in 100."""
    reach = 0.0
    for track in tracks.values():
        alive = track.alive
        first = np.take_along_axis(track.positions, np.argmax(alive, axis=0)[None, :, None], axis=0)
        offsets = np.sqrt(((track.positions - first) ** 2).sum(axis=2))
        furthest = np.max(offsets, axis=0, initial=0.0, where=alive)
        if furthest.size:
            reach = max(reach, float(np.quantile(furthest, 0.95)))
    return reach

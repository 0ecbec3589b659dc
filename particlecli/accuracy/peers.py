"""SciPy's integrators on the same scene, through the same equations of motion, for comparison."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.integrate import DOP853, LSODA

from particlecli.accuracy.tracks import Doubles, Track, Tracks
from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.masses import masses
from particlecli.dynamics.plan import Plan
from particlecli.dynamics.sampling import spread

if TYPE_CHECKING:
    from particlecli.dynamics.probe import Probe
    from particlecli.dynamics.system import System

MOST = 1000
"""Particles of each group that a peer follows; what SciPy spends on a particle hardly changes beyond."""

TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-12)

SMALLEST_RELATIVE = 3e-14
"""The smallest relative tolerance that SciPy takes."""

PEERS: dict[str, type] = {"SciPy DOP853": DOP853, "SciPy LSODA": LSODA}


class GaveUp(Exception):  # noqa: N818 - being slow is no error
    """A peer did not reach the end; says why."""


@dataclass
class Work:
    """What a peer spends: wall time, s; evaluations and steps, summed over particles."""

    seconds: float = 0.0
    evaluations: float = 0.0
    steps: float = 0.0

    def add(self, other: Work, times: float = 1.0) -> None:
        """Adds other work, so many times over."""
        self.seconds += other.seconds * times
        self.evaluations += other.evaluations * times
        self.steps += other.steps * times


@dataclass(frozen=True)
class PeerOutcome:
    """What a peer came to.

    Attributes:
        tracks: where it took the particles it followed, without velocities.
        work: what it spent, scaled to all particles.
        scaled: by how much its time was multiplied for that.
    """

    tracks: Tracks
    work: Work
    scaled: float


class Peer:
    """A solver of SciPy, with the particles of a group as one system of equations.

    Where all are there from the beginning it solves through all frames at once. Else it starts anew at every
    frame with those that are alive; which are is taken from the reference.

    Args:
        name: one of `PEERS`.
        system: the scene in double precision; only its equations of motion are used.
        reference: where the particles are.
        limit: wall time, s, after which it gives up.

    Attributes:
        reference: where those particles are that it follows.
    """

    def __init__(self, name: str, system: System, reference: Tracks, limit: float) -> None:
        from particlecli.dynamics.probe import Probe  # brings Taichi, which has been started by now

        self._solver = PEERS[name]
        self._plan = system.plan
        self._probes = {key: Probe(group.motion, "double") for key, group in system.groups.items()}
        self._limit = limit
        self.reference = {key: track.of(spread(len(track.ids), MOST)) for key, track in reference.items()}

    def run(self, tolerance: float) -> PeerOutcome:
        """Follow the particles with a tolerance, in m and m/s, and relative to the state.

        Raises:
            GaveUp: it did not reach the end.
        """
        tracks: Tracks = {}
        spent, total = Work(), Work()
        for plan in self._plan.groups:
            right = self.reference[plan.name]
            flights = _Flights(self._solver, plan, self._probes[plan.name], right, tolerance)
            tracks[plan.name] = flights.follow(self._plan.scene.fps, self._limit - spent.seconds)
            spent.add(flights.work)
            total.add(flights.work, plan.births.total / len(right.ids))
        return PeerOutcome(tracks, total, total.seconds / spent.seconds)


class _Flights:
    """The flights of the particles of one group."""

    def __init__(self, solver: Any, plan: GroupPlan, probe: Probe, right: Track, tolerance: float) -> None:
        table = plan.births.of(right.ids)
        parts = [table.positions] if table.velocities is None else [table.positions, table.velocities]
        self._states = np.concatenate(parts)
        self._times = table.times
        self._inverse_masses = 1.0 / masses(plan, right.ids)
        self._solver, self._probe, self._right, self._tolerance = solver, probe, right, tolerance
        self.work = Work()

    def follow(self, fps: float, limit: float) -> Track:
        """Where the particles are at all frames, in at most so much wall time, s."""
        alive = self._right.alive
        track = Track(self._right.ids, np.full((*alive.shape, 3), np.nan), None)
        last = len(alive) - 1
        if not self._times.any():
            everyone = np.arange(alive.shape[1])
            path = self._solve(everyone, last / fps, np.arange(last + 1) / last, limit)
            track.positions[:] = np.where(alive[:, :, None], path[:, :, :3], np.nan)
            return track
        for index in range(last + 1):
            living = np.flatnonzero(alive[index])
            if len(living):
                self._states[:, living] = self._solve(living, index / fps, np.ones(1), limit)[0].T
                self._times[living] = index / fps
                track.positions[index, living] = self._states[:3, living].T
        return track

    def _solve(self, which: np.ndarray, end: float, samples: Doubles, limit: float) -> Doubles:
        """States of some particles on the way to a time `end`, s, at given parts of the way.

        Each particle flies from its own time; the independent variable s runs from 0 to 1 for all of them.

        Returns:
            Shape (len(samples), particles, components).
        """
        starts, inverse_masses = self._times[which], self._inverse_masses[which]
        spans = end - starts
        shape = (len(which), len(self._states))

        def rate(s: float, flat: Doubles) -> Doubles:
            states = flat.reshape(shape).T
            slopes: Doubles = self._probe.derivative(states, starts + s * spans, inverse_masses)
            scaled: Doubles = (slopes * spans).T.ravel()
            return scaled

        path = np.empty((len(samples), shape[0] * shape[1]))
        path[samples == 0.0] = self._states[:, which].T.ravel()
        began = time.perf_counter()
        solver = self._solver(rate, 0.0, self._states[:, which].T.ravel(), 1.0, **self._options(shape[1]))
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise GaveUp(message)
            due = (samples > solver.t_old) & (samples <= solver.t)
            if due.any():
                path[due] = solver.dense_output()(samples[due]).T
            self.work.steps += len(which)
            if self.work.seconds + time.perf_counter() - began > limit:
                raise GaveUp(f"stopped after {limit:.0f} s")
        self.work.add(Work(time.perf_counter() - began, solver.nfev * len(which), 0.0))
        states: Doubles = path.reshape(len(samples), *shape)
        return states

    def _options(self, components: int) -> dict[str, Any]:
        """Tolerances, and for LSODA that each particle has a block of its own in the Jacobian."""
        options: dict[str, Any] = {
            "rtol": max(self._tolerance, SMALLEST_RELATIVE),
            "atol": self._tolerance,
        }
        if self._solver is LSODA:
            options |= {"lband": components - 1, "uband": components - 1}
        return options


def why_not(plan: Plan) -> str:
    """Why SciPy cannot follow a scene; empty if it can."""
    if plan.couplings:
        return f"{plan.couplings[0].force.type} couples particles, which they would follow one by one"
    met = next((group.name for group in plan.groups if group.planes), None)
    return f"{met} meets planes, and SciPy's integrators know no contact" if met else ""

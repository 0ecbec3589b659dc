"""Pilots: a sample of a group flown with a scheme at a pace, from each particle's birth to its end."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from particlecli.auto.grounds import Grounds
from particlecli.auto.steps import Doubles, Motion, Sampled, implicit_step
from particlecli.dynamics.group_plan import Constant, GroupPlan
from particlecli.dynamics.integrators.base import AnyScheme, ClosedForm, ImplicitRungeKutta
from particlecli.dynamics.sampling import spread
from particlecli.scene.planes import Coulomb, Plane

if TYPE_CHECKING:
    from particlecli.dynamics.birth_table import BirthTable
    from particlecli.dynamics.flights import Course, Flights

Ids = NDArray[np.int64]
Mask = NDArray[np.bool_]

SAMPLE = 400
"""Particles of a group that are flown."""

LONGEST, MOST = 300, 60_000
"""Frames of a particle's life that are flown, at most; of few particles more, up to so many of all together."""


@dataclass(frozen=True)
class Flight:
    """What a pilot found.

    Attributes:
        positions: at each frame after birth, shape (frames, n, 3), m; NaN where the flight has failed.
        evaluations: of the equations of motion, for each particle and frame.
    """

    positions: Doubles
    evaluations: float


class Pilot:
    """A sample of a group, born at their instants and flown for as long as they live.

    Args:
        plan: of the group.
        probe: its equations of motion.
        interval: from one frame to the next, s.
        until: end of the scene, s.
        table: who is born; none: a sample of the group's births.

    Attributes:
        ids, origins: their numbers, and where they are born, m, shape (n,) and (n, 3).
        interval: from one frame to the next, s.
        births: instants, s, shape (n,).
        first_frames: the same in frames.
        frames: how many frames each particle lives, shape (n,).
        flown: frames that are flown.
        sees_all: that all particles are flown as the engine flies them; these are a sample, at the ground roughly.
        lands: that bodies of springs meet planes at the ends of steps; these are particles.
    """

    sees_all = False
    lands = False

    def __init__(
        self, plan: GroupPlan, probe: Flights, interval: float, until: float, table: BirthTable | None = None
    ) -> None:
        self._plan, self.interval = plan, interval
        table = plan.births.of(spread(plan.births.total, SAMPLE)) if table is None else table
        self.ids, self.origins = table.ids, np.asarray(table.positions, float).T
        parts = [table.positions] if table.velocities is None else [table.positions, table.velocities]
        inverse = plan.constants[Constant.INVERSE_MASS]
        weights = np.full(len(table), inverse) if table.masses is None else 1.0 / table.masses
        self._start = Sampled(np.concatenate(parts).astype(float), table.times, weights)
        self._probe, self._motion = probe, Motion(probe.derivative, probe.jacobian)
        self._located = plan.contact == "located" and plan.newtonian
        self.births = table.times
        self.first_frames = table.times / interval
        self.frames = np.floor(self._lives(table, until) / interval + 1e-9).astype(np.int64)
        longest = max(LONGEST, MOST // max(1, len(self.births)))
        self.flown = int(min(self.frames.max(initial=0), longest))

    @property
    def moves(self) -> bool:
        """Whether anything but inertia moves the particles for a frame at least."""
        return self.flown > 0 and bool(self._plan.forces or self._plan.planes or self._plan.carrier)

    def fly(self, scheme: AnyScheme, *, steps: int = 1, tolerance: float | None = None) -> Flight:
        """Fly with so many equal steps in a frame, or with an error tolerated in a step."""
        if isinstance(scheme, ImplicitRungeKutta):
            return Flight(self._implicitly(scheme, steps), steps * scheme.evaluations)
        if isinstance(scheme, ClosedForm):
            raise ValueError("a closed form needs no pilot")
        found, tried = self._probe.fly(scheme, *self._start, self._course(), steps, tolerance)
        tries = (
            float(steps)
            if tolerance is None
            else float(tried.sum() / max(1, np.minimum(self.frames, self.flown).sum()))
        )
        return Flight(found, tries * scheme.evaluations)

    def _course(self) -> Course:
        from particlecli.dynamics.flights import Course

        box = self._plan.dies.outside
        corners = [[-np.inf] * 3, [np.inf] * 3] if box is None else [box.min, box.max]
        return Course(
            interval=self.interval,
            frames=np.minimum(self.frames, self.flown).astype(np.int32),
            planes=np.array([_row(plane) for plane in self._plan.planes]).reshape(-1, 8),
            located=self._located,
            box=np.array(corners, float),
        )

    def _implicitly(self, scheme: ImplicitRungeKutta, steps: int) -> Doubles:
        """Positions at each frame, as of `Flight`, by a scheme that solves equations."""
        sample = Sampled(self._start.states.copy(), self._start.times.copy(), self._start.weights)
        frames = self.frames.copy()
        grounds = Grounds(
            self._plan.planes, located=self._located, newtonian=self._plan.newtonian, count=len(self.births)
        )
        positions = np.full((self.flown, len(self.births), 3), np.nan)
        step = partial(implicit_step, scheme, self._motion)
        with np.errstate(all="ignore"):
            for index in range(self.flown):
                here = np.flatnonzero(frames > index)
                h = np.full(len(here), self.interval / steps)
                for _ in range(steps):
                    sample.states[:, here] = grounds.step(step, sample.at(here), h, here)
                    sample.times[here] += h
                positions[index, here] = sample.states[:3, here].T
                frames[~np.isfinite(sample.states).all(axis=0) | self._outside(sample.states)] = 0
        positions[~np.isfinite(positions).all(axis=2)] = np.nan
        return positions

    def _outside(self, states: Doubles) -> Mask:
        """Which particles have left the box that they live in."""
        box = self._plan.dies.outside
        if box is None:
            return np.zeros(states.shape[1], bool)
        low, high = np.array(box.min)[:, None], np.array(box.max)[:, None]
        return np.asarray(((states[:3] < low) | (states[:3] > high)).any(axis=0))

    def _lives(self, table: BirthTable, until: float) -> Doubles:
        """How long particles live at most, s: to the end, or until they are too old or, by Newton's law, too cold."""
        plan = self._plan
        lives = until - table.times
        if plan.mortal:
            lives = np.minimum(
                lives, table.lifetimes if table.lifetimes is not None else plan.constants[Constant.LIFETIME]
            )
        coldest = plan.dies.colder_than
        hot = table.temperatures
        if hot is not None and coldest is not None and plan.cooling is not None and plan.cooling.radiative is None:
            ambient = plan.cooling.ambient
            rates = plan.constants[Constant.COOLING_RATE] if table.cooling_rates is None else table.cooling_rates
            with np.errstate(all="ignore"):
                cold = np.log((hot - ambient) / (coldest - ambient)) / rates
            lives = np.where(np.isfinite(cold), np.minimum(lives, cold), lives)
        return np.maximum(lives, 0.0)


def _row(plane: Plane) -> list[float]:
    """A plane as a row of `Course.planes`."""
    offset = float(np.dot(plane.normal, plane.point))
    friction = plane.friction
    dry, wet = (friction.coulomb, 0.0) if isinstance(friction, Coulomb) else (0.0, friction.viscous)
    return [*plane.normal, offset, plane.restitution, float(plane.on_hit != "bounce"), dry, wet]

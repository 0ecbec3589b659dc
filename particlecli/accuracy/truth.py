"""What a scene comes to without any integrator of this package: SciPy's DOP853 in double precision."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import OdeSolution, solve_ivp

from particlecli.accuracy.bodies import (
    ABSOLUTE_TOLERANCE,
    RELATIVE_TOLERANCE,
    Bodies,
    CannotJudgeError,
    Doubles,
    Mask,
    flight,
)
from particlecli.accuracy.touch import Ground, lowered
from particlecli.dynamics.births import EmitterBirths
from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.masses import masses

if TYPE_CHECKING:
    from particlecli.dynamics.probe import Probe
    from particlecli.dynamics.system import System
    from particlecli.frame import Frame

Ids = NDArray[np.int64]

SAMPLES = 4
"""Instants in a step of DOP853 at which events are looked for."""

NARROW = 1e-9
"""How exactly an event is found before its last correction, in parts of the time until then."""

MOST_EVENTS = 5000
"""Events of one particle within a frame that are followed."""

TOGETHER = 128
"""Events that are found together."""


class GroupTruth:
    """The particles of one group, each on its own: born, flying, meeting planes.

    Args:
        plan: of the group, in double precision.
        probe: its equations of motion.
        interval: a frame, s.
    """

    def __init__(self, plan: GroupPlan, probe: Probe, interval: float) -> None:
        self._plan = plan
        self._probe = probe
        self._ground = Ground(plan.planes, self._free, interval)
        self._killed: set[int] = set()
        self._bodies = self._newborn(-np.inf, 0.0, None)
        self._time = 0.0

    def _free(self, bodies: Bodies) -> Doubles:
        return self._probe.derivative(bodies.states, bodies.times, bodies.inverse_masses)

    def advance(self, until: float, survivors: Ids) -> tuple[Ids, Doubles]:
        """Go on to a time, with those alone that will be alive then.

        Returns:
            Their numbers and positions, m, shape (n, 3); without those that a plane has killed.
        """
        bodies = self._bodies.rows(np.isin(self._bodies.ids, survivors))
        bodies = bodies.joined(self._newborn(self._time, until, survivors)) if until > self._time else bodies
        bodies.reach = np.abs(bodies.x).max(axis=0, initial=0.0)
        self._follow(bodies, until)
        self._bodies, self._time = bodies.rows(~np.isin(bodies.ids, list(self._killed))), until
        return self._bodies.ids, self._bodies.x.T.copy()

    def _newborn(self, after: float, until: float, survivors: Ids | None) -> Bodies:
        births = self._plan.births
        if isinstance(births, EmitterBirths):
            table = births.between(after, until)
        else:
            table = births.table(0, births.total if after < 0 else 0)
        if survivors is not None:
            table = table.rows(np.flatnonzero(np.isin(table.ids, survivors)))
        moving = () if table.velocities is None else (table.velocities,)
        states = np.concatenate([table.positions, *moving])
        bodies = Bodies.born(table.ids, states, table.times, 1.0 / masses(self._plan, table.ids))
        if self._plan.planes:
            killed = self._ground.settle(bodies)
            self._killed.update(bodies.ids[killed].tolist())
        return bodies

    def _follow(self, bodies: Bodies, until: float) -> None:
        """Bring all bodies to a time, event by event."""
        ends = np.full(len(bodies), until)
        for _ in range(MOST_EVENTS):
            late = bodies.times < ends
            if not late.any():
                return
            part = bodies.rows(late)
            killed = self._fly(part, ends[late])
            self._killed.update(part.ids[killed].tolist())
            bodies.put(late, part)
            ends[np.flatnonzero(late)[killed]] = -np.inf
        raise CannotJudgeError(
            f"a particle of {self._plan.name} has more than {MOST_EVENTS} impacts before t = {until:.6g} s"
        )

    def _fly(self, bodies: Bodies, ends: Doubles) -> Mask:
        """Bring bodies to their ends, or to their first events before; true for those killed."""
        solution = flight(bodies, ends, self._ground.slopes)
        killed = np.zeros(len(bodies), bool)
        spans = ends - bodies.times
        start = bodies.copy()
        bodies.states[:] = solution(1.0).reshape(bodies.states.shape)
        bodies.times[:] = ends
        if self._plan.planes:
            low, high = self._brackets(start, spans, solution)
            for k, plane in enumerate(self._plan.planes):
                there = (bodies.on == k) & np.isinf(high)
                bodies.put(there, lowered(plane, bodies.rows(there)))
            eventful = np.flatnonzero(np.isfinite(high))
            for first in range(0, len(eventful), TOGETHER):
                which = eventful[first : first + TOGETHER]
                part = start.rows(which)
                killed[which] = self._meet(part, low[which] * spans[which], high[which] * spans[which])
                bodies.put(which, part)
        return killed

    def _brackets(self, start: Bodies, spans: Doubles, solution: OdeSolution) -> tuple[Doubles, Doubles]:
        """Between which s the first event of each body lies; the later one infinite where there is none."""
        low, high = np.zeros(len(start)), np.full(len(start), np.inf)
        steps = solution.ts
        parts = np.arange(1, SAMPLES + 1) / SAMPLES
        samples = (steps[:-1, None] + np.diff(steps)[:, None] * parts).ravel()
        for s in samples:
            states = solution(s).reshape(start.states.shape)
            past = (self._ground.gaps(start.at(states, start.times + s * spans)) < 0).any(axis=0)
            high[past & np.isinf(high)] = s
            low[np.isinf(high)] = s
        return low, high

    def _meet(self, bodies: Bodies, low: Doubles, high: Doubles) -> Mask:
        """Bring bodies to their first events, `low` to `high` from now, s, and let these happen."""
        start, ground = bodies.copy(), self._ground
        solution = flight(start, start.times + high, ground.slopes)

        def each_at(s: Doubles) -> Bodies:
            states = solution(s).reshape(*start.states.shape, len(s))
            return start.at(np.diagonal(states, axis1=1, axis2=2), start.times + s * high)

        before, after = low / high, np.ones(len(start))
        while (after - before > NARROW * after).any():
            middle = (before + after) / 2
            past = (ground.gaps(each_at(middle)) < 0).any(axis=0)
            before, after = np.where(past, before, middle), np.where(past, middle, after)
        event = np.argmin(ground.gaps(each_at(after)), axis=0)
        bodies.times[:] = start.times + after * high
        bodies.states[:] = flight(start, bodies.times, ground.slopes)(1.0).reshape(bodies.states.shape)
        delay = np.clip(ground.delay(bodies, event), -1e-6 * high, 1e-6 * high)
        bodies.states += delay * ground.slopes(bodies)
        bodies.times += delay
        return ground.settle(bodies, turned=event == len(self._plan.planes) + 1)


class SystemTruth:
    """All particles of a scene together, where they are the same all the time and meet no plane.

    Args:
        system: the scene in double precision, at t = 0; is moved.
    """

    def __init__(self, system: System) -> None:
        self._system = system
        self._state = system.get_state()
        self._time = 0.0

    def at(self, until: float) -> Frame:
        """The frame at a time, s, not before the one asked for last."""
        if until > self._time:
            outcome = solve_ivp(
                self._slopes,
                (self._time, until),
                self._state,
                method="DOP853",
                rtol=RELATIVE_TOLERANCE,
                atol=ABSOLUTE_TOLERANCE,
            )
            self._state, self._time = outcome.y[:, -1], until
            if not outcome.success or not np.isfinite(self._state).all():
                raise CannotJudgeError(f"SciPy cannot integrate the motion until t = {until:.6g} s: {outcome.message}")
        self._system.set_state(self._state)
        return self._system.frame(0, {})

    def _slopes(self, time: float, state: Doubles) -> Doubles:
        self._system.set_state(state)
        return self._system.derivative(time)

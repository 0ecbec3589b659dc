"""Pilots of particles that act on each other: all of them are flown, from the beginning of the scene."""

from __future__ import annotations

from contextlib import nullcontext, suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from particlecli.auto.pilot import Flight
from particlecli.auto.terms import lands, remembers
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import AdaptiveRungeKutta, AnyScheme
from particlecli.dynamics.plan import Coupling, Plan, make_plan
from particlecli.errors import SimulationError
from particlecli.scene.forces import Attraction, SoftSphere, Springs
from particlecli.scene.integrator import Integrator, Scheme

if TYPE_CHECKING:
    from particlecli.dynamics.system import System

WORK, EVEN, WORTH = 2.5e9, 2.0, 1e9
"""Pairs of particles that the flight which others are compared with may look at, about; so many times more where bodies
land, as fewer flights of them are needed; and of how many a flight of the fewest frames is worth trying."""

NEAR, TOUCHING, FAR, NEIGHBOR = 300, 60, 1000, 5
"""How many others act on a particle, at a guess: some 30 near it, or 6 that touch it, of which each costs as much as 10
of those that attract all others; of these, by a tree, at most. And what each that a spring holds costs."""

HARD = 4
"""Times as much work is to be expected where particles attract each other without softening and may meet."""

FEWEST, CALLS = 4, 50
"""Frames that are worth flying, and evaluations in one, at a guess."""


def looks(plan: Plan) -> float:
    """Pairs of particles that an evaluation of a plan's coupled groups looks at, about."""
    count = sum(group.capacity for group in plan.groups if group.coupled)
    return sum(_looks(each, plan, count) for each in plan.couplings)


def _looks(coupling: Coupling, plan: Plan, count: int) -> float:
    force = coupling.force
    if isinstance(force, Attraction):
        return count * min(count, FAR)
    if isinstance(force, SoftSphere):
        return count * TOUCHING
    if not isinstance(force, Springs):
        return count * NEAR
    from particlecli.stability.springs import joined_pairs  # brings SciPy, which other scenes do without

    return NEIGHBOR * sum(2 * len(joined_pairs(force, group)) for group in plan.groups if group.name in coupling.groups)


def worth_flying(plan: Plan) -> bool:
    """Whether the coupled groups of a plan are few enough for pilots to tell anything."""
    hard = any(isinstance(each.force, Attraction) and not each.force.softening for each in plan.couplings)
    return looks(plan) * CALLS * FEWEST * (HARD if hard else 1) <= WORTH


def name_of(scheme: AnyScheme) -> Scheme:
    """The name by which a scene asks for a scheme."""
    return next(name for name, each in SCHEMES.items() if each is scheme)


class WholePilot:
    """The groups of a scene whose particles act on each other, flown from t = 0 for some frames.

    Args:
        plan: of the scene.

    Attributes:
        first_frames: instants of birth in frames, 0: ages count from the beginning of the scene; shape (n,).
        frames: how many frames the scene has after the first, shape (n,).
        flown: frames that are flown; the first flight ends when it has been enough work, and sets it.
        lands: whether bodies of springs meet planes at the ends of steps.
        moves: that there is something to fly for.
    """

    moves = True

    def __init__(self, plan: Plan) -> None:
        self._scene = plan.scene
        self._looks = looks(plan)
        self._first = True
        self.flown = plan.scene.frame_count - 1
        self.lands = lands(plan)
        self._totals = {group.name: group.births.total for group in plan.groups if group.coupled}
        count = sum(self._totals.values())
        self.first_frames = np.zeros(count)
        self.frames = np.full(count, plan.scene.frame_count - 1)
        self._systems: dict[Scheme, System] = {}
        self._flights: dict[tuple[Scheme, int, float | None], Flight] = {}

    @property
    def sees_all(self) -> bool:
        """Whether all of the scene is flown, to a frame that can be known."""
        return self.flown == self._scene.frame_count - 1 and not remembers(self._scene)

    def fly(self, scheme: AnyScheme, *, steps: int = 1, tolerance: float | None = None) -> Flight:
        """Fly with so many equal steps in a frame, or with an error tolerated in a step; the same flight only once.

        A flight that fails has no positions from then on; the first one must not fail.

        Raises:
            SimulationError: it did.
        """
        key = (name_of(scheme), steps, tolerance)
        if key not in self._flights:
            self._flights[key] = self._fly(scheme, steps, tolerance)
        return self._flights[key]

    def _fly(self, scheme: AnyScheme, steps: int, tolerance: float | None) -> Flight:
        system = self._system(scheme)
        system.plan = replace(system.plan, steps_per_frame=steps)
        assert system.coupled
        if tolerance is not None:
            system.coupled.tolerance = tolerance
        system.restart()
        positions = np.full((self.flown, len(self.frames), 3), np.nan)
        flown = 0
        with nullcontext() if self._first else suppress(SimulationError):
            while flown < self.flown and not (self._first and flown >= FEWEST and self._enough(system)):
                system.advance((flown + 1) / self._scene.fps)
                self._note(system, flown + 1, positions[flown])
                flown += 1
        if self._first:
            self.flown, self._first = flown, False
        return Flight(positions[: self.flown], system.evaluations / max(1, flown * len(self.frames)))

    def _enough(self, system: System) -> bool:
        return system.evaluations / len(self.frames) * self._looks > WORK * (EVEN if self.lands else 1.0)

    def _note(self, system: System, index: int, positions: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> None:
        frame, first = system.frame(index, {}), 0
        for name, total in self._totals.items():
            group = frame.groups[name]
            positions[first + group.ids] = group.positions
            first += total

    def _system(self, scheme: AnyScheme) -> System:
        from particlecli.dynamics.system import System

        name = name_of(scheme)
        if name not in self._systems:
            adaptive = isinstance(scheme, AdaptiveRungeKutta)
            integrator = Integrator(
                type=name, dt=None if adaptive else 1.0 / self._scene.fps, contact=self._scene.integrator.contact
            )
            plan = make_plan(self._scene.model_copy(update={"integrator": integrator}))
            bound = replace(plan, groups=tuple(group for group in plan.groups if group.coupled), broods=())
            self._systems[name] = System(bound, retraces=False)
            self._systems[name].compile()
        return self._systems[name]

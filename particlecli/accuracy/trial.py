"""One scheme on one scene, tried at many paces: what each costs, and where it takes the particles."""

from __future__ import annotations

import time
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, replace

from particlecli.accuracy.energy import EnergyDrift
from particlecli.accuracy.tracks import Ids, Tracks, follow
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.plan import Plan, make_plan
from particlecli.dynamics.sampling import thinned
from particlecli.interruption import heed
from particlecli.runtime import Precision
from particlecli.scene.checks import problems
from particlecli.scene.integrator import ADAPTIVE, Integrator, Scheme
from particlecli.scene.model import Scene

SHORT = 0.5
"""Runs are timed again until they have taken as long as this together, s."""


@dataclass(frozen=True)
class Pace:
    """How long the steps of a trial are.

    Attributes:
        steps: equal steps in a frame; none for an adaptive scheme.
        tolerance: error tolerated in a step, as in the scene; none for a scheme of equal steps.
    """

    steps: int | None = None
    tolerance: float | None = None


@dataclass(frozen=True)
class Outcome:
    """What a trial came to.

    Attributes:
        tracks: where the particles were at every frame.
        seconds: wall time of the simulation alone; of several the shortest, which other work disturbed least.
        evaluations: evaluations of the equations of motion, summed over all particles.
        particle_steps: steps, likewise.
        energy_drift: as of `EnergyDrift.of`.
    """

    tracks: Tracks
    seconds: float
    evaluations: int
    particle_steps: int
    energy_drift: float | None


class Trial:
    """A scene with a scheme, built once and run at many paces. The Taichi runtime must run in its precision.

    Args:
        plan: of the scene with the scheme, see `trial_plan`.
        ids: whose tracks are kept, by group.
        measures_energy: whether to look at the drift of energy too.

    Attributes:
        plan: what was built.
        system: the particles.
    """

    def __init__(self, plan: Plan, ids: Mapping[str, Ids], *, measures_energy: bool = True) -> None:
        from particlecli.dynamics.system import System  # brings Taichi

        self.plan = plan
        self._ids = ids
        self.system = System(plan, retraces=False)
        self.system.compile()
        self._energy = EnergyDrift(self.system) if measures_energy else None
        self._warm = False

    def shortened(self, scene: Scene) -> Trial:
        """The same trial of a scene that ends earlier and is otherwise the same."""
        shorter = copy(self)
        shorter.plan = replace(self.plan, scene=self.plan.scene.model_copy(update={"duration": scene.duration}))
        return shorter

    def run(self, pace: Pace, *, repeats: int = 1) -> Outcome:
        """Run the scene to its end; again, up to `repeats` times in all, if it is short.

        Raises:
            SimulationError: it did not reach the end.
        """
        system = self.system
        system.plan = replace(self.plan, steps_per_frame=pace.steps or 1)
        if pace.tolerance is not None:
            for group in system.groups.values():
                group.plan = replace(group.plan, tolerance=pace.tolerance)
            if system.coupled:
                system.coupled.tolerance = pace.tolerance
        tracks, seconds = follow(system, self._ids)
        cold = not self._warm and repeats > 1  # the first run also compiles what births and deaths need
        times = [self._seconds() if cold else seconds]
        while len(times) < repeats and sum(times) < SHORT:
            times.append(self._seconds())
        self._warm = True
        return Outcome(
            tracks,
            min(times),
            system.evaluations,
            system.particle_steps,
            self._energy.of(tracks) if self._energy else None,
        )

    def _seconds(self) -> float:
        self.system.restart()
        scene = self.plan.scene
        began = time.perf_counter()
        for index in range(scene.frame_count):
            heed()
            self.system.advance(index / scene.fps)
        return time.perf_counter() - began


def trial_plan(scene: Scene, scheme: Scheme, precision: Precision, most: int) -> Plan:
    """The plan of a scene with another scheme, a step a frame and at most so many births in each group.

    They are drawn beforehand, so that the time of a trial is that of the integrator.
    """
    longest = None if scheme in ADAPTIVE else 1.0 / scene.fps
    return thinned(make_plan(_with_scheme(scene, scheme, precision, longest)), most)


def suitable(scene: Scene) -> list[Scheme]:
    """The schemes that can run a scene."""
    return [scheme for scheme in SCHEMES if not problems(_with_scheme(scene, scheme, "double", None))]


def _with_scheme(scene: Scene, scheme: Scheme, precision: Precision, longest: float | None) -> Scene:
    integrator = Integrator(type=scheme, dt=longest, contact=scene.integrator.contact, allow_unstable=True)
    return scene.model_copy(update={"integrator": integrator, "precision": precision})

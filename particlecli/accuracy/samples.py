"""The particles that an estimate of the error looks at, and how they are carried again."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from particlecli.accuracy.tracks import Doubles, Ids, found
from particlecli.dynamics.births import BirthTable
from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.sampling import spread
from particlecli.errors import SimulationError

if TYPE_CHECKING:
    from particlecli.dynamics.group import Group
    from particlecli.dynamics.rerun import Repeated, Stretch
    from particlecli.dynamics.system import System
    from particlecli.simulate import Simulation

SHARE = 1 / 150
"""Of a group's births that are in the sample; carried at half the step that is a fiftieth of the work."""

SMALLEST, LARGEST = 48, 512
"""Particles of a group in the sample, where there are as many."""

QUARTER = 4
"""One in so many of the sample is carried at a quarter of the step too, to see whether solutions converge, and is
looked at at one in so many of the frames."""

FEWEST = 16
"""The same for small samples, where there are as many: a pack."""

HEAVY = 3e6
"""Evaluations for packs of 16 after which the sample counts as heavy: it is then carried at twice the step."""

TIGHTER = 1 / 64
"""Of an adaptive scheme's tolerance: the tolerance of the second solution; the third has that share of it again."""

SMALLEST_TOLERANCE = {4: 1e-7, 8: 3e-15}
"""By bytes of a number: below, rounding hides what the tolerance is about."""

MOST_TOGETHER, MOST_WORK = 4096, 3e6
"""Particles that act on each other, and evaluations for them in the run, up to which all of them are carried again."""


class Sample:
    """The sampled particles of a group: their births, and where the run had them.

    Attributes:
        group: of which they are.
        ids: their numbers.
        positions: at each compared frame, shape (frames, n, 3), m; NaN where they are not alive.
        heavy: whether they are carried again at twice the step instead of half of it.
        once: whether they are not carried a third time.
    """

    once = False

    def __init__(self, group: Group, frames: int, steps: int) -> None:
        from particlecli.dynamics.rerun import prepare, room

        total = group.plan.births.total
        most = min(room(group), max(SMALLEST, min(LARGEST, int(SHARE * total))))
        ids = spread(total, most)
        self.group, self.ids = group, ids
        self.births: BirthTable = group.plan.births.of(ids)
        self.positions = np.full((frames, len(ids), 3), np.nan)
        if not self.flies_straight:
            prepare(group, self.births)
        packs = -(-len(ids) // FEWEST)
        work = packs * steps * group.plan.scheme.evaluations
        self.heavy = work > HEAVY and len(ids) > 2 * SHARE * total and not group.plan.adaptive

    @property
    def flies_straight(self) -> bool:
        """Whether nothing acts on the particles, so that rounding alone is wrong."""
        plan = self.group.plan
        return plan.newtonian and not plan.forces and not plan.planes

    @property
    def checked(self) -> Ids:
        """Places in the sample of those that are carried a third time."""
        return spread(len(self.ids), max(FEWEST, len(self.ids) // QUARTER))

    def again(self, places: Ids, refinement: int, times: Doubles, counts: Ids) -> Repeated:
        """Carry some of the sample with steps or tolerances refined once, twice or, coarser, −1 times."""
        from particlecli.dynamics.rerun import Stretch, rerun

        plan = self.group.plan
        stretches: list[Stretch] = [
            Stretch(float(time), max(1, round(count * 2.0**refinement)))
            for time, count in zip(times, counts, strict=True)
        ]
        tolerance = tighter(plan, refinement) if plan.adaptive else None
        return rerun(self.group, self.births.rows(places), stretches, tolerance)


class BoundSample(Sample):
    """The particles of a group that act on each other or on those of other groups: all of them, with all the others."""

    def __init__(self, group: Group, frames: int, together: Together) -> None:
        self.group = group
        self.ids = np.arange(group.plan.births.total)
        self.births = group.plan.births.of(self.ids)
        self.positions = np.full((frames, len(self.ids), 3), np.nan)
        self.heavy = False
        self._together = together

    @property
    def flies_straight(self) -> bool:
        """Never: others act on them."""
        return False

    @property
    def checked(self) -> Ids:
        """Places of those that are carried a third time: all."""
        return np.arange(len(self.ids))

    def again(self, places: Ids, refinement: int, times: Doubles, counts: Ids) -> Repeated:  # noqa: ARG002
        """Where some of them are after a run with steps or tolerances refined once or twice."""
        return self._together.again(refinement, times)[self.group.plan.name]


class Together:
    """Runs of the whole system with refined steps, each made once."""

    def __init__(self, system: System, groups: list[str]) -> None:
        self._system, self._groups = system, groups
        self._runs: dict[int, tuple[Doubles, dict[str, Repeated]]] = {}

    def again(self, refinement: int, times: Doubles) -> dict[str, Repeated]:
        """By group, the particles at these times, s; not finite any more, none is there."""
        if refinement not in self._runs:
            self._runs[refinement] = times, self._run(refinement, times)
        return self._runs[refinement][1]

    def _run(self, refinement: int, times: Doubles) -> dict[str, Repeated]:
        from particlecli.dynamics.rerun import Repeated, run_again

        system, scene = self._system, self._system.plan.scene
        totals = {name: system.groups[name].plan.births.total for name in self._groups}
        runs = {
            name: Repeated(np.full((len(times), total, 3), np.nan), np.zeros((len(times), total)))
            for name, total in totals.items()
        }
        plan = system.groups[self._groups[0]].plan
        factor = 1.0 if plan.adaptive else 2.0**refinement
        with run_again(system, factor, tighter(plan, refinement) if plan.adaptive else None):
            try:
                for index in range(1, scene.frame_count):
                    system.advance(index / scene.fps)
                    for row in np.flatnonzero(np.abs(times - system.time) < 1e-9):
                        _note(system, runs, int(row))
            except SimulationError:
                pass
        return runs


def _note(system: System, runs: dict[str, Repeated], row: int) -> None:
    frame = system.frame(0, dict.fromkeys(runs, frozenset({"velocities"})))
    for name, run in runs.items():
        group = frame.groups[name]
        here, there = found(np.arange(run.positions.shape[1]), group.ids)
        run.positions[row, here] = group.positions[there]
        if group.velocities is not None:
            run.speeds[row, here] = np.linalg.norm(group.velocities[there], axis=1)


def tighter(plan: GroupPlan, refinement: int) -> float:
    """The tolerance of an adaptive scheme, refined so many times."""
    return max(plan.tolerance * TIGHTER**refinement, SMALLEST_TOLERANCE[plan.real_bytes])


def bound_samples(simulation: Simulation, frames: list[int]) -> dict[str, Sample]:
    """By group, samples of particles that act on each other, where these are few; else there are none."""
    groups = {name: group for name, group in simulation.system.groups.items() if group.plan.coupled}
    particles = sum(group.plan.births.total for group in groups.values())
    steps = simulation.plan.steps_per_frame * (simulation.scene.frame_count - 1)
    work = particles * steps * max((group.plan.scheme.evaluations for group in groups.values()), default=0)
    if not frames or not particles or particles > MOST_TOGETHER or work > MOST_WORK:
        return {}
    together = Together(simulation.system, list(groups))
    return {
        name: BoundSample(group, len(frames), together) for name, group in groups.items() if group.plan.births.total
    }

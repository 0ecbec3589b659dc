"""Particles that act on each other in the estimate of the error: the whole system is carried again."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from particlecli.accuracy import prices
from particlecli.accuracy.samples import (
    COARSER,
    FINER,
    FINER_ALONE,
    FIXED,
    LEAST_STEPS,
    Carrier,
    Comparison,
    Sample,
    nowhere,
    ratio_in_frames,
    tighter,
    work_of,
)
from particlecli.accuracy.tracks import Doubles, Ids, found
from particlecli.errors import SimulationError

if TYPE_CHECKING:
    from particlecli.dynamics.group import Group
    from particlecli.dynamics.rerun import Repeated
    from particlecli.dynamics.system import System
    from particlecli.simulate import Simulation

MOST_TOGETHER = 100_000
"""Particles that act on each other up to which all of them may be carried again."""


class BoundSample(Sample):
    """The particles of a group that act on each other or on those of other groups: all of them, with all the others."""

    def __init__(self, group: Group, frames: int, together: Together) -> None:
        self.group = group
        self.ids = np.arange(group.plan.births.total)
        self.births = group.plan.births.of(self.ids)
        self.positions = np.full((frames, len(self.ids), 3), np.nan)
        self._together = together

    @property
    def carrier(self) -> Carrier:
        """All that act on each other."""
        return self._together

    @property
    def flies_straight(self) -> bool:
        """Never: others act on them."""
        return False

    @property
    def checked(self) -> Ids:
        """Places of those that are carried a third time: all."""
        return np.arange(len(self.ids))

    def again(self, places: Ids, refinement: int, times: Doubles, counts: Ids) -> Repeated:  # noqa: ARG002
        """Where some of them are after a run with steps or tolerances refined or coarser."""
        return self._together.again(refinement, times)[self.group.plan.name]

    def ratio(self, refinement: int, counts: Ids) -> float:  # noqa: ARG002
        """How many times as long the longer steps are, of the run's own and of refined ones."""
        return self._together.ratio(refinement)


class Together(Carrier):
    """Runs of the whole system with refined steps, each made once."""

    def __init__(self, system: System, groups: list[str]) -> None:
        self._system, self._groups = system, groups
        self._plan = system.groups[groups[0]].plan
        self._runs: dict[int, dict[str, Repeated]] = {}
        others = [group.name for group in system.plan.groups if not group.coupled]
        self._idle = [] if system.plan.broods else others  # on which nothing depends, unless they bear some

    def comparisons(self) -> list[Comparison]:
        """With solutions that are checked if that can be paid for."""
        if self._plan.adaptive:
            return [FINER, FINER_ALONE]
        return [FINER, COARSER] if self._system.plan.steps_per_frame >= LEAST_STEPS else [FINER]

    def price(self, comparison: Comparison) -> float:
        """What a comparison costs, s."""
        plan = self._system.plan
        calls = len(comparison.refinements) * plan.scene.frame_count * prices.CALL
        work = sum(work_of(self._plan, refinement) for refinement in comparison.refinements)
        moving = prices.coupled(self._system) + (prices.alone(self._system) if plan.broods else 0.0)
        return FIXED * len(self._groups) + calls + work * moving

    def ratio(self, refinement: int) -> float:
        """How many times as long the longer steps are, of the run's own and of refined ones."""
        return ratio_in_frames(self._system.plan.steps_per_frame, refinement)

    def again(self, refinement: int, times: Doubles) -> dict[str, Repeated]:
        """By group, the particles at these times, s; not finite any more, none is there."""
        if refinement not in self._runs:
            self._runs[refinement] = self._run(refinement, times)
        return self._runs[refinement]

    def _run(self, refinement: int, times: Doubles) -> dict[str, Repeated]:
        from particlecli.dynamics.rerun import run_again

        system, fps = self._system, self._system.plan.scene.fps
        runs = {name: nowhere(len(times), system.groups[name].plan.births.total) for name in self._groups}
        adaptive = self._plan.adaptive
        tolerance = tighter(self._plan, refinement) if adaptive else None
        each = prices.coupled(system) / max(1, sum(system.group_evaluations[name] for name in self._groups))
        with run_again(system, 1.0 if adaptive else 2.0**refinement, tolerance, without=self._idle):
            try:
                for index in range(1, system.plan.scene.frame_count):
                    system.advance(index / fps)
                    for row in np.flatnonzero(np.abs(times - system.time) < 1e-9):
                        _note(system, runs, int(row))
                    if system.evaluations * each > self.granted:
                        for run in runs.values():
                            run.complete = False
                        break
            except SimulationError:
                pass
            self.granted -= system.evaluations * each
        return runs


def _note(system: System, runs: dict[str, Repeated], row: int) -> None:
    frame = system.frame(0, dict.fromkeys(runs, frozenset({"velocities"})))
    for name, run in runs.items():
        group = frame.groups[name]
        here, there = found(np.arange(run.positions.shape[1]), group.ids)
        run.positions[row, here] = group.positions[there]
        if group.velocities is not None:
            run.speeds[row, here] = np.linalg.norm(group.velocities[there], axis=1)


def bound_samples(simulation: Simulation, frames: list[int]) -> dict[str, Sample]:
    """By group, samples of particles that act on each other; of very many there are none."""
    groups = {name: group for name, group in simulation.system.groups.items() if group.plan.coupled}
    particles = sum(group.plan.births.total for group in groups.values())
    if not frames or not 0 < particles <= MOST_TOGETHER:
        return {}
    together = Together(simulation.system, list(groups))
    return {
        name: BoundSample(group, len(frames), together) for name, group in groups.items() if group.plan.births.total
    }

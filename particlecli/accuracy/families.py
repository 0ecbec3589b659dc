"""Children in the estimate of the error: some particles are carried again with all that they bear."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from particlecli.accuracy import prices
from particlecli.accuracy.samples import (
    COARSER_ALONE,
    FINER_ALONE,
    FIXED,
    LARGEST,
    Carrier,
    Comparison,
    Sample,
    nowhere,
    ratio_in_frames,
    tighter,
    work_of,
)
from particlecli.accuracy.tracks import Doubles, Ids, found
from particlecli.dynamics.sampling import spread
from particlecli.errors import SimulationError

if TYPE_CHECKING:
    from particlecli.dynamics.group import Group
    from particlecli.dynamics.rerun import Repeated
    from particlecli.dynamics.system import System
    from particlecli.simulate import Simulation


EARLY = 0.7
"""Of the births of a group, those that may be chosen."""


class Families(Carrier):
    """Some of the particles that have no parents, and all their descendants, in a run with refined steps.

    Attributes:
        roots: by group, numbers of those without parents.
        ids: by group of children, numbers of descendants that are looked at.
    """

    def __init__(self, system: System) -> None:
        self._system = system
        self.roots = self._chosen()
        everyone = self._descendants(self.roots)
        self._counts = {name: len(ids) for name, ids in everyone.items()}
        self.ids = {
            name: ids[spread(len(ids), LARGEST)]
            for name, ids in everyone.items()
            if len(ids) and not system.groups[name].plan.births.total
        }
        self._found: dict[str, Repeated] | None = None

    def comparisons(self) -> list[Comparison]:
        """With one solution: families are large."""
        plan = self._system.plan
        adaptive = next(iter(self._system.groups.values())).plan.adaptive
        return [FINER_ALONE] if adaptive or plan.steps_per_frame == 1 else [FINER_ALONE, COARSER_ALONE]

    def price(self, comparison: Comparison) -> float:
        """What a comparison costs, s."""
        plan, work = self._system.plan, 0.0
        for name, count in self._counts.items():
            group, born = self._system.groups[name].plan, self._system.births[name]
            each = self._system.group_evaluations[name] / born if born else 0.0
            work += work_of(group, comparison.refinement) * prices.carried(group, plan, each, count)
        calls = plan.scene.frame_count * len(plan.groups) * prices.CALL
        return FIXED * len(self.ids) + calls + work

    def _chosen(self) -> dict[str, Ids]:
        """So many that their descendants make up a sample, one at least; not the last ones."""
        broods = self._system.plan.broods
        totals = {name: group.plan.births.total for name, group in self._system.groups.items()}
        roots = {}
        for name in {brood.parent for brood in broods if totals[brood.parent]}:
            one = self._descendants({name: np.zeros(1, np.int64)})
            family = sum(len(ids) for ids in one.values())
            early = max(1, int(EARLY * totals[name]))
            roots[name] = spread(early, max(1, LARGEST // family))
        return roots

    def _descendants(self, roots: dict[str, Ids]) -> dict[str, Ids]:
        """By group, numbers of these and of all that may descend from them."""
        found = {name: [ids] for name, ids in roots.items()}
        for brood in self._system.plan.broods:  # those of a group come before those of its children
            parents = np.concatenate(found.get(brood.parent, [np.empty(0, np.int64)]))
            children = brood.numbers(np.repeat(parents, brood.each), np.tile(np.arange(brood.each), len(parents)))
            found.setdefault(brood.child, []).append(children)
        return {name: np.sort(np.concatenate(parts)) for name, parts in found.items()}

    def again(self, refinement: int, times: Doubles) -> dict[str, Repeated]:
        """By group of children, where they are at these times, s, in a run with other steps; run once."""
        if self._found is None:
            self._found = self._run(refinement, times)
        return self._found

    def ratio(self, refinement: int) -> float:
        """How many times as long the longer steps are, of the run's own and of refined ones."""
        return ratio_in_frames(self._system.plan.steps_per_frame, refinement)

    def _run(self, refinement: int, times: Doubles) -> dict[str, Repeated]:
        from particlecli.dynamics.rerun import run_again

        system, interval = self._system, 1.0 / self._system.plan.scene.fps
        runs = {name: nowhere(len(times), len(ids)) for name, ids in self.ids.items()}
        plan = next(iter(system.groups.values())).plan
        frames = np.round(times / interval).astype(int)
        tolerance = tighter(plan, refinement) if plan.adaptive else None
        with run_again(system, 1.0 if plan.adaptive else 2.0**refinement, tolerance, self.roots):
            try:
                for index in range(system.plan.scene.frame_count):
                    system.advance(index * interval)
                    for row in np.flatnonzero(frames == index):
                        self._note(runs, int(row))
            except SimulationError:
                pass
        return runs

    def _note(self, runs: dict[str, Repeated], row: int) -> None:
        frame = self._system.frame(0, dict.fromkeys(runs, frozenset({"velocities"})))
        for name, run in runs.items():
            group = frame.groups[name]
            here, there = found(self.ids[name], group.ids)
            run.positions[row, here] = group.positions[there]
            if group.velocities is not None:
                run.speeds[row, here] = np.linalg.norm(group.velocities[there], axis=1)


class ChildSample(Sample):
    """Particles of a group that are born of others, carried again with their parents."""

    def __init__(self, group: Group, frames: int, families: Families) -> None:
        self.group, self._families = group, families
        self.ids = families.ids[group.plan.name]
        self.positions = np.full((frames, len(self.ids), 3), np.nan)

    @property
    def carrier(self) -> Carrier:
        """The families they are of."""
        return self._families

    @property
    def flies_straight(self) -> bool:
        """Never: where they begin depends on their parents."""
        return False

    def again(self, places: Ids, refinement: int, times: Doubles, counts: Ids) -> Repeated:  # noqa: ARG002
        """Where they are in a run with other steps."""
        return self._families.again(refinement, times)[self.group.plan.name]

    def ratio(self, refinement: int, counts: Ids) -> float:  # noqa: ARG002
        """How many times as long the longer steps are, of the run's own and of refined ones."""
        return self._families.ratio(refinement)


def child_samples(simulation: Simulation, frames: list[int]) -> dict[str, Sample]:
    """By group, samples of particles that are born of others; of those alone that no one else bears."""
    if not simulation.plan.broods or not frames:
        return {}
    families = Families(simulation.system)
    return {name: ChildSample(simulation.system.groups[name], len(frames), families) for name in families.ids}

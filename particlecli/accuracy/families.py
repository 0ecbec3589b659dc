"""Children in the estimate of the error: some particles are carried again with all that they bear."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from particlecli.accuracy.samples import LARGEST, Sample, tighter
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


class Families:
    """Some of the particles that have no parents, and all their descendants, in a run with refined steps.

    Attributes:
        roots: by group, numbers of those without parents.
        ids: by group of children, numbers of descendants that are looked at.
    """

    def __init__(self, system: System) -> None:
        self._system = system
        self.roots = self._chosen()
        everyone = self._descendants(self.roots)
        self.ids = {
            name: ids[spread(len(ids), LARGEST)]
            for name, ids in everyone.items()
            if len(ids) and not system.groups[name].plan.births.total
        }
        self._found: dict[str, Repeated] | None = None

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

    def again(self, times: Doubles) -> dict[str, Repeated]:
        """By group of children, where they are at these times, s, in a run at half the step; run once."""
        if self._found is None:
            self._found = self._run(times)
        return self._found

    def _run(self, times: Doubles) -> dict[str, Repeated]:
        from particlecli.dynamics.rerun import Repeated, run_again

        system, interval = self._system, 1.0 / self._system.plan.scene.fps
        runs = {
            name: Repeated(np.full((len(times), len(ids), 3), np.nan), np.zeros((len(times), len(ids))))
            for name, ids in self.ids.items()
        }
        plan = next(iter(system.groups.values())).plan
        frames = np.round(times / interval).astype(int)
        with run_again(system, 1.0 if plan.adaptive else 2.0, tighter(plan, 1) if plan.adaptive else None, self.roots):
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

    once = True

    def __init__(self, group: Group, frames: int, families: Families) -> None:
        self.group, self._families = group, families
        self.ids = families.ids[group.plan.name]
        self.positions = np.full((frames, len(self.ids), 3), np.nan)
        self.heavy = False

    def again(self, places: Ids, refinement: int, times: Doubles, counts: Ids) -> Repeated:  # noqa: ARG002
        """Where they are in a run at half the step."""
        return self._families.again(times)[self.group.plan.name]


def child_samples(simulation: Simulation, frames: list[int]) -> dict[str, Sample]:
    """By group, samples of particles that are born of others; of those alone that no one else bears."""
    if not simulation.plan.broods or not frames:
        return {}
    families = Families(simulation.system)
    return {name: ChildSample(simulation.system.groups[name], len(frames), families) for name in families.ids}

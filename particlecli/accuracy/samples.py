"""The particles that an estimate of the error looks at, and how they are carried again."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from particlecli.accuracy import prices
from particlecli.accuracy.tracks import Doubles, Ids
from particlecli.dynamics.birth_table import BirthTable
from particlecli.dynamics.group_plan import LANES, GroupPlan
from particlecli.dynamics.sampling import spread

if TYPE_CHECKING:
    from particlecli.dynamics.group import Group
    from particlecli.dynamics.rerun import Repeated, Stretch
    from particlecli.dynamics.system import System

SHARE = 1 / 150
"""Of a group's births that are in the sample; carried at half the step that is a fiftieth of the work."""

SMALLEST, LARGEST = 48, 512
"""Particles of a group in the sample, where there are as many."""

QUARTER = 4
"""One in so many of the sample is carried at a quarter of the step too, to see whether solutions converge, and is
looked at at one in so many of the frames."""

FEWEST = 16
"""The same for small samples, where there are as many: a pack."""

TIGHTER = 1 / 64
"""Of an adaptive scheme's tolerance: the tolerance of the second solution; the third has that share of it again."""

SMALLEST_TOLERANCE = {4: 1e-7, 8: 3e-15}
"""By bytes of a number: below, rounding hides what the tolerance is about."""

FIXED = 8e-3
"""The price of comparing a group beside what its particles evaluate, s, see `prices`."""


@dataclass(frozen=True)
class Comparison:
    """With what other solutions a run is compared.

    Attributes:
        refinement: how often the steps of the second solution are halved or, if negative, doubled; of an adaptive
            scheme how often its tolerance is tightened.
        check: the same of the third, which tells whether solutions converge; none: there is none.
    """

    refinement: int
    check: int | None

    @property
    def refinements(self) -> tuple[int, ...]:
        """Of the second solution, and of the third if there is one."""
        return (self.refinement,) if self.check is None else (self.refinement, self.check)


FINER, COARSER = Comparison(1, 2), Comparison(-1, -2)
FINER_ALONE, COARSER_ALONE = Comparison(1, None), Comparison(-1, None)

LEAST_STEPS = 4
"""Steps that can be made twice and four times as long."""


class Carrier:
    """Particles that are carried again together, as far as a budget allows.

    Attributes:
        comparison: how they are compared; none: they are not.
        granted: price of what may still be carried, s.
    """

    comparison: Comparison | None = FINER
    granted = math.inf

    def comparisons(self) -> list[Comparison]:
        """Ways to compare them, the best first."""
        raise NotImplementedError

    def price(self, comparison: Comparison) -> float:
        """What a comparison costs, s, told from what the run has evaluated."""
        raise NotImplementedError

    def grant(self, price: float) -> float:
        """Choose the best comparison that costs no more, s; returns what it costs."""
        for comparison in self.comparisons():
            if (cost := self.price(comparison)) <= max(0.0, price):
                self.comparison, self.granted = comparison, price
                return cost
        self.comparison = None
        return 0.0


class Sample(Carrier):
    """The sampled particles of a group: their births, and where the run had them.

    Attributes:
        group: of which they are.
        ids: their numbers.
        positions: at each compared frame, shape (frames, n, 3), m; NaN where they are not alive.
    """

    def __init__(self, group: Group, system: System, frames: int) -> None:
        from particlecli.dynamics.rerun import prepare, room

        total = group.plan.births.total
        most = min(room(group), max(SMALLEST, min(LARGEST, int(SHARE * total))))
        ids = spread(total, most)
        self.group, self.ids, self._system = group, ids, system
        self.births: BirthTable = group.plan.births.of(ids)
        self.positions = np.full((frames, len(ids), 3), np.nan)
        if not self.flies_straight:
            prepare(group, self.births)

    @property
    def carrier(self) -> Carrier:
        """With which they are carried again."""
        return self

    @property
    def flies_straight(self) -> bool:
        """Whether nothing acts on the particles, so that rounding alone is wrong."""
        plan = self.group.plan
        return plan.newtonian and not plan.forces and not plan.planes

    @property
    def checked(self) -> Ids:
        """Places in the sample of those that are carried a third time."""
        return spread(len(self.ids), max(FEWEST, len(self.ids) // QUARTER))

    def comparisons(self) -> list[Comparison]:
        """With solutions that are checked if that can be paid for."""
        if self.group.plan.adaptive:
            return [FINER, FINER_ALONE]
        plan = self._system.plan
        return [FINER, COARSER] if plan.steps_per_frame * (plan.scene.frame_count - 1) > LEAST_STEPS else [FINER]

    def price(self, comparison: Comparison) -> float:
        """What a comparison costs, s."""
        if self.flies_straight:
            return 0.0
        each = self._evaluations()
        work = [each * work_of(self.group.plan, refinement) for refinement in comparison.refinements]
        counts = (len(self.ids), len(self.checked))
        return FIXED + sum(
            prices.carried(self.group.plan, self._system.plan, evaluations, count)
            for evaluations, count in zip(work, counts, strict=False)
        )

    def _evaluations(self) -> float:
        """How many each particle took in the run; of packs, which are seldom full where births are spread in time, as
        many as fill the time."""
        plan, whole = self.group.plan, self._system.plan
        each = self._system.group_evaluations[plan.name] / plan.births.total
        steps = 0 if plan.adaptive else whole.steps_per_frame * (whole.scene.frame_count - 1)
        return max(each, steps * plan.scheme.evaluations / math.ceil(len(self.ids) / LANES))

    def again(self, places: Ids, refinement: int, times: Doubles, counts: Ids) -> Repeated:
        """Carry some of the sample with steps or tolerances refined so many times or, if negative, coarser."""
        from particlecli.dynamics.rerun import Stretch, rerun

        plan = self.group.plan
        stretches: list[Stretch] = [
            Stretch(float(time), max(1, round(count * 2.0**refinement)))
            for time, count in zip(times, counts, strict=True)
        ]
        tolerance = tighter(plan, refinement) if plan.adaptive else None
        each = prices.carried(plan, self._system.plan, 1.0, len(places)) / len(places)
        found = rerun(self.group, self.births.rows(places), stretches, tolerance, self.granted / each)
        self.granted -= found.evaluations * each
        return found

    def ratio(self, refinement: int, counts: Ids) -> float:
        """How many times as long the longer steps are, of the run's own and of refined ones, between these frames."""
        return ratio_of(float(counts.sum()), float(np.maximum(1.0, np.round(counts * 2.0**refinement)).sum()))


def nowhere(frames: int, count: int) -> Repeated:
    """Where particles are that have not been carried anywhere."""
    from particlecli.dynamics.rerun import Repeated

    return Repeated(np.full((frames, count, 3), np.nan), np.zeros((frames, count)))


def ratio_of(steps: float, others: float) -> float:
    """How many times as many steps the one of two solutions takes that takes more."""
    return max(steps, others) / min(steps, others)


def ratio_in_frames(steps: int, refinement: int) -> float:
    """The same of runs of so many steps a frame, and of others refined so many times or, if negative, coarser."""
    return ratio_of(steps, max(1, round(steps * 2.0**refinement)))


def work_of(plan: GroupPlan, refinement: int) -> float:
    """How many times as much work a refined solution is."""
    if plan.adaptive:
        return float((plan.tolerance / tighter(plan, refinement)) ** (1.0 / plan.scheme.order))
    return 2.0**refinement


def tighter(plan: GroupPlan, refinement: int) -> float:
    """The tolerance of an adaptive scheme, refined so many times."""
    return max(plan.tolerance * TIGHTER**refinement, SMALLEST_TOLERANCE[plan.real_bytes])

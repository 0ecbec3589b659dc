"""Some of a group's particles carried through the scene once more, by the same kernels in other steps."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.birth_table import BirthTable
from particlecli.dynamics.births import SampledBirths
from particlecli.dynamics.group_plan import LANES, GroupPlan
from particlecli.dynamics.newborn import columns_of

if TYPE_CHECKING:
    from particlecli.dynamics.group import Group
    from particlecli.dynamics.system import System

Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class Stretch:
    """A stretch of the run: its end, s, and the equal steps it is cut into; an adaptive scheme chooses its own."""

    until: float
    steps: int


@dataclass
class Repeated:
    """What a rerun found.

    Attributes:
        positions: at the end of each stretch, shape (stretches, n, 3), m; NaN where a particle is not alive.
        speeds: likewise, shape (stretches, n), m/s; of a first-order group zero.
        evaluations: that it took, summed over the particles.
        complete: whether it went on to the end, and not only until it had taken as many as it might.
    """

    positions: Doubles
    speeds: Doubles
    evaluations: int = 0
    complete: bool = True


def room(group: Group) -> int:
    """How many particles a rerun can carry at most: whole packs of the group's memory."""
    return -(-group.state.capacity // LANES) * LANES


def prepare(group: Group, births: BirthTable) -> None:
    """Compile what a rerun needs beyond the group's own kernels, by carrying one particle nowhere."""
    with _lent(group, 1, None):
        group.state.append(columns_of(births.rows(np.zeros(1, np.int64)), 0.0))
        group.state.read(group.plan.motion_components)
        if group.has("fate"):
            group.state.read(("fate",))


def rerun(
    group: Group,
    births: BirthTable,
    stretches: Sequence[Stretch],
    tolerance: float | None = None,
    most: float = math.inf,
) -> Repeated:
    """Carry particles from their births to the end of the last stretch.

    They borrow the group's first packs and its kernels, so nothing is built or compiled; the group is left as it was.
    A particle that is not finite any more ends the rerun: from there on none is there.

    Args:
        group: whose memory and kernels are used.
        births: in order of birth, not more than there is `room` for.
        stretches: from t = 0 on, one after the other.
        tolerance: of an adaptive scheme; none: the group's own.
        most: evaluations, summed over the particles, after which no further stretch is begun.
    """
    found = Repeated(np.full((len(stretches), len(births), 3), np.nan), np.zeros((len(stretches), len(births))))
    with _lent(group, len(births), tolerance):
        carried = _Carried(group, births)
        time = 0.0
        for index, stretch in enumerate(stretches):
            carried.bear(time, stretch.until)
            if found.evaluations > most:
                found.complete = False
                break
            well = carried.advance(time, stretch)
            found.evaluations = carried.evaluations
            if not well:
                break
            carried.note(found, index)
            time = stretch.until
    return found


class _Carried:
    """The particles of a rerun: which births they are, and their state."""

    def __init__(self, group: Group, births: BirthTable) -> None:
        self._group, self._births = group, births
        self._places = np.empty(0, np.int64)
        self._born = 0
        self.evaluations = 0

    def bear(self, time: float, until: float) -> None:
        """Add those born up to a time, s."""
        last = int(np.searchsorted(self._births.times, until, side="right"))
        if last > self._born:
            places = np.arange(self._born, last)
            self._group.state.append(columns_of(self._births.rows(places), time))
            self._places = np.concatenate([self._places, places])
            self._born = last

    def advance(self, time: float, stretch: Stretch) -> bool:
        """Go to the end of a stretch; whether all are finite there."""
        state = self._group.state
        if not state.count or stretch.until == time:
            return True
        outcome = self._group.advance(time, stretch.until - time, stretch.steps)
        self.evaluations += outcome.evaluations
        if outcome.died:
            self._places = self._places[state.read(("fate",))[0] <= 0]
            state.bury()
        return outcome.failed_slot is None

    def note(self, found: Repeated, index: int) -> None:
        """Write down where those are that are alive."""
        if not self._group.state.count:
            return
        motion = self._group.state.read(self._group.plan.motion_components).astype(np.float64)
        found.positions[index, self._places] = motion[:3].T
        if self._group.plan.newtonian:
            found.speeds[index, self._places] = np.linalg.norm(motion[3:], axis=0)


@contextmanager
def _lent(group: Group, count: int, tolerance: float | None) -> Iterator[None]:
    """The group emptied and, at the end, as it was; `count` particles at most are there between."""
    state, plan = group.state, group.plan
    whole = state.count
    state.count = min(whole, count)
    kept = {name: state.read((name,))[0] for name in plan.components} if state.count else {}
    state.count = 0
    if tolerance is not None:
        group.plan = replace(plan, tolerance=tolerance)
    try:
        yield
    finally:
        group.plan = plan
        state.count = 0
        if kept:
            state.append(kept)
        state.count = whole


@contextmanager
def run_again(
    system: System,
    refinement: float,
    tolerance: float | None = None,
    births: Mapping[str, NDArray[np.int64]] | None = None,
    without: Collection[str] = (),
) -> Iterator[System]:
    """A system at t = 0 again, with so many times the steps; afterwards it is as it was.

    Args:
        system: whose groups and kernels are used.
        refinement: by which its equal steps a frame are multiplied.
        tolerance: of an adaptive scheme; none: the scene's own.
        births: by group, numbers of the particles that are born without parents, none in other groups; none: all are.
        without: groups in which none are born without parents.
    """
    kept = {
        name: {component: group.state.read((component,))[0] for component in group.plan.components}
        for name, group in system.groups.items()
    }
    names = ("plan", "time", "births", "deaths", "particle_steps", "group_evaluations", "_born_until")
    before = {name: getattr(system, name) for name in names}
    plans = {name: group.plan for name, group in system.groups.items()}
    coupled = system.coupled
    usual = coupled.tolerance if coupled else None
    system.plan = replace(system.plan, steps_per_frame=max(1, round(system.plan.steps_per_frame * refinement)))
    try:
        for name, group in system.groups.items():
            group.plan = _with(plans[name], tolerance, {} if name in without else births)
        if coupled and tolerance is not None:
            coupled.tolerance = tolerance
        system.restart()
        yield system
    finally:
        for name, value in before.items():
            setattr(system, name, value)
        if coupled and usual is not None:
            coupled.tolerance = usual
        for name, group in system.groups.items():
            group.plan = plans[name]
            group.state.count = 0
            if len(kept[name]["x"]):
                group.state.append(kept[name])


def _with(plan: GroupPlan, tolerance: float | None, births: Mapping[str, NDArray[np.int64]] | None) -> GroupPlan:
    """A plan with another tolerance, and with some of its births."""
    changed = plan if tolerance is None else replace(plan, tolerance=tolerance)
    if births is None:
        return changed
    return replace(changed, births=SampledBirths(plan.births, births.get(plan.name, np.empty(0, np.int64))))

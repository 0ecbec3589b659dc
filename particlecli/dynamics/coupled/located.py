"""Steps of a few coupled particles that end at the instants of impacts on planes."""

import taichi as ti

from particlecli.dynamics.coupled.footing import RELEASE
from particlecli.dynamics.coupled.serial import SerialMarch
from particlecli.dynamics.coupled.step import Step
from particlecli.dynamics.group_plan import LANES
from particlecli.dynamics.integrators.adaptive import AdaptiveStepper
from particlecli.dynamics.plane_events import NONE

MOST_TRIALS = 200_000
"""Trials, by packs, in steps in a row in which something happens; then a step goes on regardless, and what is below a
plane at its end comes to rest on it."""

MOST_SEARCHED = 100
"""Trials for one event, which is taken for found then."""

BISECTION = 8
"""One in so many trials halves the time in which an event is searched."""


@ti.data_oriented
class LocatedMarch(SerialMarch):
    """A serial march that cuts the step of all where the first particle meets a plane, and goes on from there.

    An event is found as a root of the scheme's own step length, so that it is as exact as the scheme.

    Args:
        step, stepper: as of `SerialMarch`; the step has impacts.
    """

    def __init__(self, step: Step, stepper: AdaptiveStepper | None = None) -> None:
        super().__init__(step, stepper)
        self.impacts = step.impacts
        self.search = ti.types.struct(
            kind=ti.i32,  # of the event that is searched, see `CoupledImpacts.survey`
            where=ti.i32,  # its place among all lanes
            low=self.real,  # length of the longest trial that ends before it, s
            high=self.real,  # of the shortest in which it happens, s
        )

    @ti.func
    def _stride(self, packs, t0, now, h, whole, again, tolerance, crowd):
        """As `SerialMarch._stride`."""
        lies = self._entered(packs, t0, now, h)
        rests, tries = 0, 0
        search = self.search(NONE, NONE, 0.0, h)
        trial, taken, error = h, 0.0 * h, 0.0 * h
        while taken == 0.0:
            rests = self._try(packs, t0, now, trial, whole, lies * (tries == 0), rests)
            tries += 1
            if ti.static(self.adapts):  # noqa: SIM102 - one of tracing, one of the kernel
                if tries == 1:
                    error = self._error(packs, tolerance)
            if error > 1.0:
                taken = trial
            elif (tries == 1) & (crowd > MOST_TRIALS // ti.max(packs, 1)):
                for b in range(packs):
                    self.impacts.lift(b)
                taken = trial
            else:
                taken, trial = self._judged(packs, trial, whole, tries, search)
            if taken == 0.0:
                for b in range(packs):
                    self.step.revert(b)
        return taken, error, tries

    @ti.func
    def _judged(self, packs, trial, whole, tries, search: ti.template()):
        """How far a trial is taken, and how long the next one is.

        It is taken to its end, and what happens there has happened, or not at all, and the search goes on.
        """
        taken, following = 0.0 * trial, trial
        exactness = self.impacts.tolerance * whole
        first, place, due, near, turn = self._survey(packs, trial, search.kind, search.where, exactness)
        happened, sought = first != NONE, search.kind != NONE
        if happened:
            search.kind, search.where, search.high = first, place, trial
        elif sought:
            search.low = trial
        narrow = (search.high - search.low <= exactness) | (tries >= MOST_SEARCHED)
        lets_off = (search.kind >= RELEASE) & (not happened)
        if (not happened) & (not sought):
            if (turn < trial) & (not narrow):
                following = turn
            else:
                taken = trial
                for b in range(packs):
                    self.impacts.calm(b)
        elif ((near != 0) & (not lets_off)) | (sought & narrow):
            if lets_off:
                following = search.high
            else:
                taken = trial
                self._strike(packs, search.kind, search.where, exactness, trial <= self.impacts.instant * whole)
        else:
            inside = (due > search.low) & (due < search.high) & (tries % BISECTION != 0)
            following = ti.select(inside, due, 0.5 * (search.low + search.high))
        return taken, following

    @ti.func
    def _entered(self, packs, t0, now, h):
        """Begin with particles below planes struck; 1 if any lie on a plane."""
        lies = 0
        for b in range(packs):
            self.step.begin(b, t0, now, h)
            lies = ti.max(lies, self.impacts.enter(b))
        return lies

    @ti.func
    def _try(self, packs, t0, now, h, whole, lies, rests):
        """The motion in a step of length h; 1 if particles rest in it.

        Args:
            whole: length of the step that it is a part of, s.
            lies: whether to look first what rests.
            rests: whether anything is known to rest.
        """
        stands = rests
        for b in range(packs):
            self.step.begin(b, t0, now, h)
        for i in range(-1, self.step.evaluations + 1):
            before, after = i < 0, i == self.step.evaluations
            if ((not before) & (not after)) | (before & (lies != 0)) | (after & (stands != 0)):
                for b in range(packs):
                    self.step.evaluate(i, b, t0 + now + self.step.times[ti.max(i, 0)] * h)
                for b in range(packs):
                    if before:
                        stands = ti.max(stands, self.impacts.footing.find(b, whole))
                        self.step.begin(b, t0, now, h)
                    elif not after:
                        self.step.follow(i, b, t0 + now, h)
        return stands

    @ti.func
    def _survey(self, packs, trial, kind, where, exactness):
        """The first event of all, as of `CoupledImpacts.survey`; its place among all lanes."""
        first, place, due, near, turn = NONE, NONE, 1e30 + 0.0 * trial, 0, trial
        for b in range(packs):
            lane = where - b * LANES
            lane = ti.select((where != NONE) & (lane >= 0) & (lane < LANES), lane, NONE)
            one, each, when, close, lowest = self.impacts.survey(b, trial, kind, lane, exactness)
            turn = ti.min(turn, lowest)
            earlier = (one != NONE) & ((first == NONE) | (when < due))
            if earlier | ((first == NONE) & (lane != NONE)):
                due, near = when, close
            if earlier:
                first, place = one, b * LANES + each
        return first, place, due, near, turn

    @ti.func
    def _strike(self, packs, kind, where, exactness, quick):
        for b in range(packs):
            lane = where - b * LANES
            lane = ti.select((lane >= 0) & (lane < LANES), lane, NONE)
            self.impacts.strike(b, kind, lane, exactness, quick)

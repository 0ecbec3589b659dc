"""Impacts located in time, rest and friction on planes: the careful way through a step that meets a plane.

Most packs meet no plane in a frame and never come here. A pack that does takes its step again piece by piece: from
event to event, each found as a root of the integrator's own step length, so an impact is as exact as the scheme.
"""

import taichi as ti

from particlecli.dynamics.algebra import both, choose
from particlecli.dynamics.contacts import PlaneContact, length
from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.impact_record import ImpactRecord
from particlecli.dynamics.integrators.steppers import stepper
from particlecli.dynamics.memory import FieldMemory
from particlecli.dynamics.plane_events import MOST_STALLS, NONE, SLIDING_STOPS, PlaneEvents
from particlecli.dynamics.resting import RestingMotion

MOST_EVENTS = 2_000_000
"""Trial steps in one step; a particle that needs more is put to rest."""


@ti.data_oriented
class CarefulStepper:
    """A step of particles that meet planes, from event to event.

    Args:
        plan: what the group needs.
        motion: its equations of motion.
        contacts: its planes.
        first_contact: where their parameters begin in the parameter lists.
        real: type of the numbers.
        record: where impacts are noted that bear children; none where none do.
        memory: where its tables go.

    Attributes:
        events: at those planes.
    """

    def __init__(
        self,
        plan: GroupPlan,
        motion,
        contacts: list[PlaneContact],
        first_contact: int,
        real,
        record: ImpactRecord | None,
        memory: FieldMemory,
    ) -> None:
        self.motion = RestingMotion(motion, contacts, first_contact)
        self.stepper = stepper(plan.scheme, self.motion, real, memory)
        self.contacts = contacts
        self.first = first_contact
        self.record = record
        self.notes = record is not None
        self.events = PlaneEvents(plan, contacts, first_contact)

    @ti.func
    def step(self, p, state, t, h, own, fate, live: ti.template()):
        """State (six packs) and fate after a step of length h that may meet planes; `own` as of `March.advance`."""
        x, y, z, u, v, w, outcome = self.events.entered(p, state, fate, live)
        left = ti.select(both(live, outcome == fate), h + 0.0 * x, 0.0)
        low, high, guess = 0.0 * x, 0.0 * x, 0.0 * x
        reach = left
        target = ti.select(x == x, NONE, NONE)
        events, stalls = 0, 0
        tolerance, instant = self.events.tolerance * h, self.events.instant * h
        while (left > 0.0) & (events < MOST_EVENTS) & (stalls < 2 * MOST_STALLS):
            events += 1
            now = t + (h - left)
            resting, f0, f1, f2 = self._footing(p, [x, y, z, u, v, w], now, h, own[3])
            x, y, z, u, v, w = self.events.grounded(p, [x, y, z, u, v, w], resting)
            trial = ti.select(target == NONE, ti.min(left, reach), guess)
            new = self._moved(p, [x, y, z, u, v, w], now, trial, own[3], [resting, f0, f1, f2])
            first, due, near = self.events.first_event(
                p, [x, y, z, u, v, w], new, resting, [f0, f1, f2], trial, target, tolerance
            )
            happened = first != NONE
            turn = self.events.turn(p, [x, y, z, u, v, w], new, resting, trial)
            dips = (target == NONE) & (happened == 0) & (turn < trial)
            reach = ti.select(dips, turn, left)
            low = ti.select(happened | dips, low, trial)
            high = ti.select(happened, trial, high)
            was_searching = target != NONE
            target = ti.select(happened, first, target)
            searching = target != NONE
            narrow = (high - low) <= tolerance
            accepted = searching & (near | (was_searching & narrow))
            inside = (due > low) & (due < high)
            guess = ti.select(inside, due, 0.5 * (low + high))
            advanced = (left > 0.0) & (accepted | (searching == 0)) & (dips == 0)
            x, y, z, u, v, w = [choose(advanced, new[c], [x, y, z, u, v, w][c]) for c in ti.static(range(6))]
            left = ti.select(advanced, ti.max(left - trial, 0.0), left)
            x, y, z, u, v, w, outcome = self._met(
                p, [x, y, z, u, v, w], now + trial, own, outcome, target, advanced & accepted, stalls
            )
            left = ti.select(outcome == fate, left, 0.0)
            stalls = ti.select(advanced, ti.select(accepted & (trial <= instant), stalls + 1, 0), stalls)
            target = ti.select(advanced, NONE, target)
            low = ti.select(advanced, 0.0, low)
        if left > 0.0:
            u, v, w = 0.0 * u, 0.0 * v, 0.0 * w
        return [x, y, z, u, v, w, outcome]

    @ti.func
    def undisturbed(self, p, state, t, h, own):
        """The state after a step of particles that rest on planes, and a mask of those to which nothing else happens.

        For those it is what `step` leads to, to the last bit, at the cost of its first trial.
        """
        resting, f0, f1, f2 = self._footing(p, state, t, h, own[3])
        old = self.events.grounded(p, state, resting)
        whole = h + 0.0 * state[0]
        new = self._moved(p, old, t, whole, own[3], [resting, f0, f1, f2])
        target = ti.select(whole == whole, NONE, NONE)
        first, _, _ = self.events.first_event(
            p, old, new, resting, [f0, f1, f2], whole, target, self.events.tolerance * h
        )
        calm = (resting != 0) & (first == NONE) & (self.events.turn(p, old, new, resting, whole) >= whole)
        for k in ti.static(range(len(self.contacts))):
            calm = calm & (self.events.enters(p[self.first + k], k, state) == 0)
        return new, calm

    @ti.func
    def _moved(self, p, state, t, h, inverse_mass, footing):
        """The state after a step of length h without impacts; `footing` as of `PlaneEvents.footing`."""
        faint = ti.select(footing[0] != 0, self.events.faint * length(state[3:]), 0.0)
        return self.stepper.step(p, state, t, h, [inverse_mass] + footing + [faint])

    @ti.func
    def _met(self, p, state, t, own, fate, target, found, stalls):
        """State and fate after the event `target`, of those in the mask `found`."""
        x, y, z, u, v, w, outcome = state[0], state[1], state[2], state[3], state[4], state[5], fate
        stops = found & (target == SLIDING_STOPS)
        u, v, w = ti.select(stops, 0.0, u), ti.select(stops, 0.0, v), ti.select(stops, 0.0, w)
        for k in ti.static(range(len(self.contacts))):
            hit = found & (target == k)
            q = p[self.first + k]
            x, y, z, u, v, w, outcome = self.events.struck(q, k, [x, y, z, u, v, w], outcome, hit)
            u, v, w = self.events.flattened(q, k, [u, v, w], hit & (stalls >= MOST_STALLS))
            self._note(own, hit, t, [x, y, z, u, v, w])
        return [x, y, z, u, v, w, outcome]

    @ti.func
    def _note(self, own, hit, t, state):
        if ti.static(self.notes):  # noqa: SIM102 - one of tracing, one of the kernel
            if hit:
                self.record.write(own[4], t, state)

    @ti.func
    def _footing(self, p, state, t, h, inverse_mass):
        return self.events.footing(p, state, self.motion.motion.derivative(p, state, t, [inverse_mass])[3:], h)

"""What happens to coupled particles at planes within a step, pack by pack: impacts, rest, release, friction."""

import taichi as ti

from particlecli.dynamics.algebra import dot
from particlecli.dynamics.contacts import length
from particlecli.dynamics.coupled.ending import Ending
from particlecli.dynamics.group_plan import LANES
from particlecli.dynamics.plane_events import NONE, SLIDING_STOPS
from particlecli.dynamics.resting import rests_on

RELEASE = 32
"""With the number of a plane added: the event that forces cease to press a resting particle onto it."""

LOOSELY = 1e-6
"""Of the pressing at the beginning of a step: what may be left of it when a particle is let off. A kink in the
acceleration that is missed by a time δ is worth δ² in the velocity, so that need not be found any better."""

NEVER = 1e30
"""A time that does not come, s."""

MOST_STALLS = 60
"""Impacts of a particle in a row with hardly any time between them after which it no longer bounces; after twice as
many, as in a corner, it stops."""

SWEEPS = 8
"""How often particles that have come to an end below planes are put onto one after the other."""


@ti.data_oriented
class CoupledImpacts:
    """The planes that coupled groups meet at the instants of impacts.

    A step begins with `enter`; where particles lie on planes they find their `foot`ing, and planes hold them in the
    step. Then `survey` looks for the first event within it. Once the step ends at that event, particles are `struck`.

    Args:
        ending: of steps; its groups, points and states at the beginning of the step.

    Attributes:
        resting: field of packs of bits: the planes that particles rest on in this step.
        footing: field of packs, shape (4, packs): the direction in which they slide or are pulled, and the speed below
            which a velocity has no direction, m/s.
        pressing: field of packs, shape (planes, packs): what presses them onto each plane at the beginning, m/s².
        raw: field of packs, shape (3, packs): accelerations as if there were no planes, m/s².
        stalls: field of packs: impacts in a row with hardly any time between them.
        tolerance, instant: as of `PlaneEvents`.
    """

    def __init__(self, ending: Ending) -> None:
        self.ending = ending
        self.points = ending.points
        self.groups = ending.groups
        self.located = ending.located
        pack = ti.types.vector(LANES, self.points.real)
        integers = ti.types.vector(LANES, ti.i32)
        packs = self.points.capacity
        planes = max(len(self.groups[g].march.contacts) for g in self.located)
        self.resting, self.stalls = ti.field(integers, shape=packs), ti.field(integers, shape=packs)
        self.footing, self.raw = ti.field(pack, shape=(4, packs)), ti.field(pack, shape=(3, packs))
        self.pressing = ti.field(pack, shape=(planes, packs))
        self.events = [group.march.careful_stepper.events for group in self.groups]
        self.motions = [group.march.careful_stepper.motion for group in self.groups]
        self.tolerance, self.instant = self.events[0].tolerance, self.events[0].instant

    @ti.func
    def calm(self, b):
        """Forget what happened before."""
        self.stalls[b] = ti.Vector([0] * LANES)

    @ti.func
    def enter(self, b):
        """Strike the particles of pack b that begin a step below a plane, heading in; 1 if any lie on a plane."""
        lies = 0
        self.resting[b] = ti.Vector([0] * LANES)
        for g in ti.static(self.located):
            if self.points.holds(g, b):
                lies = self._enter(g, b - self.points.firsts[g], b)
        return lies

    @ti.func
    def _enter(self, g: ti.template(), own, b):
        p, live = self.groups[g].loaded(), self.ending.reaches[b] > 0.0
        x, y, z, u, v, w, fate = self.events[g].entered(
            p, self._state(b), self.groups[g].component("fate", own, 0), live
        )
        self._put(g, own, b, [x, y, z, u, v, w], fate)
        return ti.select(live & self.events[g].lies(p, [x, y, z]), 1, 0).max()

    @ti.func
    def keep(self, b, a):
        """Keep accelerations as if there were no planes."""
        for c in ti.static(range(3)):
            self.raw[c, b] = a[c]

    @ti.func
    def foot(self, b, h):
        """Find out what pack b rests on in a step of length h, from the accelerations kept; 1 if it does."""
        rests = 0
        for g in ti.static(self.located):
            if self.points.holds(g, b):
                rests = self._foot(g, b, h)
        return rests

    @ti.func
    def _foot(self, g: ti.template(), b, h):
        p, state, a = self.groups[g].loaded(), self._state(b), self._raw(b)
        resting, f0, f1, f2 = self.events[g].footing(p, state, a, h)
        resting = ti.select(self.ending.reaches[b] > 0.0, resting, 0)
        grounded = self.events[g].grounded(p, state, resting)
        self.resting[b] = resting
        self.footing[0, b], self.footing[1, b], self.footing[2, b] = f0, f1, f2
        self.footing[3, b] = ti.select(resting != 0, self.events[g].faint * length(grounded[3:]), 0.0)
        for c in ti.static(range(6)):
            self.points.state[c, b] = grounded[c]
        supported = self.motions[g].supported(p, grounded, a, resting)
        for k in ti.static(range(len(self.events[g].contacts))):
            self.pressing[k, b] = supported[3 + k]
        return ti.select(resting != 0, 1, 0).max()

    @ti.func
    def held(self, b, a):
        """The accelerations of pack b with planes that hold what rests on them."""
        ax, ay, az = a[0], a[1], a[2]
        for g in ti.static(self.located):
            if self.points.holds(g, b) & (self.resting[b].max() > 0):
                footing = [self.resting[b]] + [self.footing[c, b] for c in ti.static(range(4))]
                ax, ay, az = self.motions[g].held(self.groups[g].loaded(), self._state(b), a, footing)
        return [ax, ay, az]

    @ti.func
    def survey(self, b, trial, kind, lane, tolerance):
        """The first event of pack b in a step of length `trial`.

        Args:
            kind, lane: the event being searched; none or of another pack: `NONE`.
            tolerance: the time by which the trial may miss it, s.

        Returns:
            Its kind and lane; when it is due, s after the beginning of the step; whether the trial ends near it, 1 or
            0; and when particles turn above a plane, or the whole trial. Where nothing happened the second pair is
            about the event being searched.
        """
        first, place, due, near, turn = NONE, NONE, 0.0 * trial + NEVER, 0, trial
        for g in ti.static(self.located):
            if self.points.holds(g, b):
                first, place, due, near, turn = self._survey(g, b, trial, kind, lane, tolerance)
        return first, place, due, near, turn

    @ti.func
    def _survey(self, g: ti.template(), b, trial, kind, lane, tolerance):
        p, reach = self.groups[g].loaded(), self.ending.reaches[b]
        old, new = [self.ending.base[c, b] for c in ti.static(range(6))], self._state(b)
        resting, forward = self.resting[b], [self.footing[c, b] for c in ti.static(range(3))]
        target = ti.select(ti.Vector(list(range(LANES))) == lane, kind, NONE)
        kinds, dues, nears = self.events[g].first_event(p, old, new, resting, forward, reach, target, tolerance)
        if resting.max() > 0:
            kinds, dues, nears = self._released(g, p, b, new, target, kinds, dues, nears)
        live, late = reach > 0.0, trial - reach
        turns = ti.select(live, late + self.events[g].turn(p, old, new, resting, reach), trial)
        whens = ti.select(live & (kinds != NONE), late + dues, NEVER)
        first, place, due, near = NONE, NONE, whens.min(), 0
        if due < NEVER:
            for each in range(LANES):
                if (place == NONE) & (whens[each] == due):
                    first, place, near = kinds[each], each, ti.select(nears[each], 1, 0)
        elif lane != NONE:
            due, near = late[lane] + dues[lane], ti.select(nears[lane], 1, 0)
        return first, place, due, near, turns.min()

    @ti.func
    def _released(self, g: ti.template(), p, b, state, target, kinds, dues, nears):
        """What `PlaneEvents.first_event` found, and particles that forces draw off a plane at the end of the trial."""
        resting, reach = self.resting[b], self.ending.reaches[b]
        supported = self.motions[g].supported(p, state, self._raw(b), resting)
        for k in ti.static(range(len(self.events[g].contacts))):
            q = p[self.events[g].first + k]
            _, margin = self.events[g].height(q, k, state[:3])
            away = dot(self.events[g].contacts[k].normal(q), supported[:3])
            pressing, start = supported[3 + k] - ti.max(away, 0.0), self.pressing[k, b]
            when = reach * start / ti.max(start - pressing, 1e-30)
            off = rests_on(resting, k) & (-pressing * reach * reach > margin)
            earlier = off & (when < ti.select(kinds == NONE, NEVER, dues))
            concerns = earlier | ((kinds == NONE) & (target == RELEASE + k))
            kinds = ti.select(earlier, RELEASE + k, kinds)
            dues = ti.select(concerns, when, dues)
            nears = ti.select(concerns, ti.abs(pressing) <= LOOSELY * start, nears)
        return kinds, dues, nears

    @ti.func
    def strike(self, b, kind, lane, tolerance, quick):
        """Let pack b meet the planes that it has come to.

        Args:
            kind, lane: the event at which the step ends, `NONE` if it is of another pack.
            tolerance: by which others may come to planes after it, s.
            quick: whether hardly any time has passed since the last event.
        """
        for g in ti.static(self.located):
            if self.points.holds(g, b):
                self._strike(g, b - self.points.firsts[g], b, kind, lane, tolerance, quick)

    @ti.func
    def _strike(self, g: ti.template(), own, b, kind, lane, tolerance, quick):
        p, live = self.groups[g].loaded(), self.ending.reaches[b] > 0.0
        x, y, z, u, v, w = self._state(b)
        fate = self.groups[g].component("fate", own, 0)
        target = ti.select(ti.Vector(list(range(LANES))) == lane, kind, NONE)
        stops = target == SLIDING_STOPS
        stalls = ti.select(quick, self.stalls[b], 0)
        for k in ti.static(range(len(self.events[g].contacts))):
            q = p[self.events[g].first + k]
            height, margin = self.events[g].height(q, k, [x, y, z])
            speed = dot(self.events[g].contacts[k].normal(q), [u, v, w])
            near = (ti.abs(height) <= 4.0 * margin + tolerance * ti.abs(speed)) & (speed < 0.0)
            hit = live & ((target == k) | (near & (rests_on(self.resting[b], k) == 0)))
            x, y, z, u, v, w, fate = self.events[g].struck(q, k, [x, y, z, u, v, w], fate, hit)
            stalls = ti.select(hit, stalls + 1, stalls)
            stops = stops | (hit & (stalls >= 2 * MOST_STALLS))
            speed = dot(self.events[g].contacts[k].normal(q), [u, v, w])
            bounce = ti.select(hit & (stalls >= MOST_STALLS), speed, 0.0)
            u, v, w = [[u, v, w][c] - self.events[g].contacts[k].normal(q)[c] * bounce for c in ti.static(range(3))]
        self.stalls[b] = stalls
        u, v, w = ti.select(stops, 0.0, u), ti.select(stops, 0.0, v), ti.select(stops, 0.0, w)
        self._put(g, own, b, [x, y, z, u, v, w], fate)

    @ti.func
    def lift(self, b):
        """Put the particles of pack b that are below planes onto them, at rest."""
        for g in ti.static(self.located):
            if self.points.holds(g, b):
                self._lift(g, b - self.points.firsts[g], b)

    @ti.func
    def _lift(self, g: ti.template(), own, b):
        p, live = self.groups[g].loaded(), self.ending.reaches[b] > 0.0
        x, y, z, u, v, w = self._state(b)
        fate = self.groups[g].component("fate", own, 0)
        for _ in range(SWEEPS):
            for k in ti.static(range(len(self.events[g].contacts))):
                q = p[self.events[g].first + k]
                height, margin = self.events[g].height(q, k, [x, y, z])
                below = live & (height < -margin)
                x, y, z, u, v, w, fate = self.events[g].struck(q, k, [x, y, z, u, v, w], fate, below)
                u, v, w = ti.select(below, 0.0, u), ti.select(below, 0.0, v), ti.select(below, 0.0, w)
        self._put(g, own, b, [x, y, z, u, v, w], fate)

    @ti.func
    def _state(self, b):
        return self.points.position(b) + self.points.velocity(b)

    @ti.func
    def _raw(self, b):
        return [self.raw[c, b] for c in ti.static(range(3))]

    @ti.func
    def _put(self, g: ti.template(), own, b, state, fate):
        for c in ti.static(range(6)):
            self.points.state[c, b] = state[c]
        if ti.static(self.groups[g].has("fate")):
            self.groups[g].state.integers[self.groups[g].state.row("fate"), own] = fate

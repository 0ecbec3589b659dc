"""What happens to coupled particles at planes within a step, pack by pack: impacts, rest, release, friction."""

import taichi as ti

from particlecli.dynamics.algebra import dot
from particlecli.dynamics.contacts import TINY, length
from particlecli.dynamics.coupled.ending import Ending
from particlecli.dynamics.dips import may_dip
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
    step. Then `survey` looks for the first event within it. Once the step ends at that event, particles `strike`.
    Packs of which nothing is near a plane are seen as such at once; in others particles go one by one.

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
                p = self.groups[g].loaded()
                if self._nearest(g, p, b) <= 0.0:
                    for lane in range(LANES):
                        if self.ending.reaches[b][lane] > 0.0:
                            lies = ti.max(lies, self._enter(g, p, b, lane))
        return lies

    @ti.func
    def _enter(self, g: ti.template(), p, b, lane):
        x, y, z, u, v, w, fate = self.events[g].entered(p, self._state(b, lane), self._fate(g, b, lane), True)
        self._put(g, b, lane, [x, y, z, u, v, w], fate)
        return ti.select(self.events[g].lies(p, [x, y, z]), 1, 0)

    @ti.func
    def _nearest(self, g: ti.template(), p, b):
        """How far the moving particles of pack b are above what counts as lying on a plane, at least, m."""
        height = 0.0 * self.points.mass[b] + NEVER
        for k in ti.static(range(len(self.events[g].contacts))):
            above, margin = self.events[g].height(p[self.events[g].first + k], k, self.points.position(b))
            height = ti.min(height, above - 8.0 * margin)
        return ti.select(self.ending.reaches[b] > 0.0, height, NEVER).min()

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
                p = self.groups[g].loaded()
                for lane in range(LANES):
                    if self.ending.reaches[b][lane] > 0.0:
                        rests = ti.max(rests, self._foot(g, p, b, lane, h))
        return rests

    @ti.func
    def _foot(self, g: ti.template(), p, b, lane, h):
        state, a = self._state(b, lane), self._raw(b, lane)
        resting, f0, f1, f2 = self.events[g].footing(p, state, a, h)
        if resting != 0:
            self.resting[b][lane] = resting
            grounded = self.events[g].grounded(p, state, resting)
            faint = self.events[g].faint * length(grounded[3:])
            for c in ti.static(range(4)):
                self.footing[c, b][lane] = [f0, f1, f2, faint][c]
            for c in ti.static(range(6)):
                self.points.state[c, b][lane] = grounded[c]
            supported = self.motions[g].supported(p, grounded, a, resting)
            for k in ti.static(range(len(self.events[g].contacts))):
                self.pressing[k, b][lane] = supported[3 + k]
        return ti.select(resting != 0, 1, 0)

    @ti.func
    def held(self, b, a):
        """The accelerations of pack b with planes that hold what rests on them."""
        ax, ay, az = a[0], a[1], a[2]
        for g in ti.static(self.located):
            if self.points.holds(g, b) & (self.resting[b].max() > 0):
                p = self.groups[g].loaded()
                for lane in range(LANES):
                    if self.resting[b][lane] != 0:
                        free = [ax[lane], ay[lane], az[lane]]
                        footing = [self.resting[b][lane]] + [self.footing[c, b][lane] for c in ti.static(range(4))]
                        held = self.motions[g].held(p, self._state(b, lane), free, footing)
                        ax[lane], ay[lane], az[lane] = held[0], held[1], held[2]
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
                p = self.groups[g].loaded()
                if (lane != NONE) | (self.resting[b].max() > 0) | self._meets(g, p, b):
                    for each in range(LANES):
                        if self.ending.reaches[b][each] > 0.0:
                            target = ti.select(each == lane, kind, NONE)
                            one, when, close, lowest = self._survey(g, p, b, each, trial, target, tolerance)
                            turn = ti.min(turn, lowest)
                            earlier = (one != NONE) & ((first == NONE) | (when < due))
                            if earlier | ((first == NONE) & (target != NONE)):
                                due, near = when, close
                            if earlier:
                                first, place = one, each
        return first, place, due, near, turn

    @ti.func
    def _meets(self, g: ti.template(), p, b):
        """Whether moving particles of pack b may have come below a plane at the end of a step or within."""
        meets = 0
        reach = self.ending.reaches[b]
        for k in ti.static(range(len(self.events[g].contacts))):
            q = p[self.events[g].first + k]
            n = ti.static(self.events[g].contacts[k].normal(q))
            before = [dot(n, [self.ending.base[c + d, b] for d in ti.static(range(3))]) for c in ti.static((0, 3))]
            after = dot(n, self.points.position(b)) - q[3]
            dips = may_dip(before[0] - q[3], before[1], after, dot(n, self.points.velocity(b)), reach)
            meets = ti.max(meets, ti.select((reach > 0.0) & ((after < 0.0) | dips), 1, 0).max())
        return meets != 0

    @ti.func
    def _survey(self, g: ti.template(), p, b, lane, trial, target, tolerance):
        """The same of one particle, without its lane."""
        reach = self.ending.reaches[b][lane]
        old, new = [self.ending.base[c, b][lane] for c in ti.static(range(6))], self._state(b, lane)
        resting, forward = self.resting[b][lane], [self.footing[c, b][lane] for c in ti.static(range(3))]
        first, due, near = self.events[g].first_event(p, old, new, resting, forward, reach, target, tolerance)
        if resting != 0:
            first, due, near = self._released(g, p, b, lane, new, target, first, due, near)
        turn = self.events[g].turn(p, old, new, resting, reach)
        late = trial - reach
        return first, late + due, ti.select(near, 1, 0), late + turn

    @ti.func
    def _released(self, g: ti.template(), p, b, lane, state, target, first, due, near):
        """What `PlaneEvents.first_event` found, or that forces draw the particle off a plane before."""
        resting, reach = self.resting[b][lane], self.ending.reaches[b][lane]
        supported = self.motions[g].supported(p, state, self._raw(b, lane), resting)
        for k in ti.static(range(len(self.events[g].contacts))):
            q = p[self.events[g].first + k]
            _, margin = self.events[g].height(q, k, state[:3])
            away = dot(self.events[g].contacts[k].normal(q), supported[:3])
            pressing, start = supported[3 + k] - ti.max(away, 0.0), self.pressing[k, b][lane]
            when = reach * start / ti.max(start - pressing, TINY)
            off = rests_on(resting, k) & (-pressing * reach * reach > margin)
            earlier = off & ((first == NONE) | (when < due))
            concerns = earlier | ((first == NONE) & (target == RELEASE + k))
            first = ti.select(earlier, RELEASE + k, first)
            due = ti.select(concerns, when, due)
            near = ti.select(concerns, ti.abs(pressing) <= LOOSELY * start, near)
        return first, due, near

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
                p = self.groups[g].loaded()
                for each in range(LANES):
                    if self.ending.reaches[b][each] > 0.0:
                        self._strike(g, p, b, each, ti.select(each == lane, kind, NONE), tolerance, quick)

    @ti.func
    def _strike(self, g: ti.template(), p, b, lane, target, tolerance, quick):
        x, y, z, u, v, w = self._state(b, lane)
        fate = self._fate(g, b, lane)
        stops = target == SLIDING_STOPS
        stalls = ti.select(quick, self.stalls[b][lane], 0)
        for k in ti.static(range(len(self.events[g].contacts))):
            q = p[self.events[g].first + k]
            n = ti.static(self.events[g].contacts[k].normal(q))
            height, margin = self.events[g].height(q, k, [x, y, z])
            speed = dot(n, [u, v, w])
            near = (ti.abs(height) <= 4.0 * margin + tolerance * ti.abs(speed)) & (speed < 0.0)
            hit = (target == k) | (near & (rests_on(self.resting[b][lane], k) == 0))
            x, y, z, u, v, w, fate = self.events[g].struck(q, k, [x, y, z, u, v, w], fate, hit)
            stalls = ti.select(hit, stalls + 1, stalls)
            stops = stops | (hit & (stalls >= 2 * MOST_STALLS))
            bounce = ti.select(hit & (stalls >= MOST_STALLS), dot(n, [u, v, w]), 0.0)
            u, v, w = [[u, v, w][c] - n[c] * bounce for c in ti.static(range(3))]
        self.stalls[b][lane] = stalls
        kept = ti.select(stops, 0.0, 1.0)
        self._put(g, b, lane, [x, y, z, kept * u, kept * v, kept * w], fate)

    @ti.func
    def lift(self, b):
        """Put the particles of pack b that are below planes onto them, at rest."""
        for g in ti.static(self.located):
            if self.points.holds(g, b):
                p = self.groups[g].loaded()
                for lane in range(LANES):
                    if self.ending.reaches[b][lane] > 0.0:
                        self._lift(g, p, b, lane)

    @ti.func
    def _lift(self, g: ti.template(), p, b, lane):
        x, y, z, u, v, w = self._state(b, lane)
        fate, kept = self._fate(g, b, lane), 1.0
        for _ in range(SWEEPS):
            for k in ti.static(range(len(self.events[g].contacts))):
                q = p[self.events[g].first + k]
                height, margin = self.events[g].height(q, k, [x, y, z])
                below = height < -margin
                x, y, z, u, v, w, fate = self.events[g].struck(q, k, [x, y, z, u, v, w], fate, below)
                kept = ti.select(below, 0.0, kept)
        self._put(g, b, lane, [x, y, z, kept * u, kept * v, kept * w], fate)

    @ti.func
    def _state(self, b, lane):
        return [self.points.state[c, b][lane] for c in ti.static(range(6))]

    @ti.func
    def _raw(self, b, lane):
        return [self.raw[c, b][lane] for c in ti.static(range(3))]

    @ti.func
    def _fate(self, g: ti.template(), b, lane):
        fate = 0
        if ti.static(self.groups[g].has("fate")):
            row = ti.static(self.groups[g].state.row("fate"))
            fate = self.groups[g].state.integers[row, b - self.points.firsts[g]][lane]
        return fate

    @ti.func
    def _put(self, g: ti.template(), b, lane, state, fate):
        for c in ti.static(range(6)):
            self.points.state[c, b][lane] = state[c]
        if ti.static(self.groups[g].has("fate")):
            row = ti.static(self.groups[g].state.row("fate"))
            self.groups[g].state.integers[row, b - self.points.firsts[g]][lane] = fate

"""What happens to coupled particles at planes within a step, pack by pack: impacts, and what comes first."""

import taichi as ti

from particlecli.dynamics.algebra import dot
from particlecli.dynamics.coupled.ending import Ending
from particlecli.dynamics.coupled.footing import Footing
from particlecli.dynamics.coupled.plane_lanes import PlaneLanes
from particlecli.dynamics.dips import may_dip
from particlecli.dynamics.group_plan import LANES
from particlecli.dynamics.plane_events import MOST_STALLS, NONE, SLIDING_STOPS
from particlecli.dynamics.resting import rests_on

NEVER = 1e30
"""A time that does not come, s; a height that no particle reaches, m."""

SWEEPS = 8
"""How often particles that have come to an end below planes are put onto one after the other."""


@ti.data_oriented
class CoupledImpacts(PlaneLanes):
    """The planes that coupled groups meet at the instants of impacts.

    A step begins with `enter`; where particles lie on planes they find their `footing`, and planes hold them in the
    step. Then `survey` looks for the first event within it. Once the step ends at that event, particles `strike`.
    Packs of which nothing is near a plane are seen as such at once; in others particles go one by one.

    Args:
        ending: as of `PlaneLanes`.

    Attributes:
        footing: what rests.
        stalls: field of packs: impacts in a row with hardly any time between them.
        tolerance, instant: as of `PlaneEvents`.
    """

    def __init__(self, ending: Ending) -> None:
        super().__init__(ending)
        self.footing = Footing(ending)
        self.stalls = ti.field(ti.types.vector(LANES, ti.i32), shape=self.points.capacity)
        self.tolerance, self.instant = self.events[0].tolerance, self.events[0].instant

    @ti.func
    def calm(self, b):
        """Forget what happened before."""
        self.stalls[b] = ti.Vector([0] * LANES)

    @ti.func
    def enter(self, b):
        """Strike the particles of pack b that begin a step below a plane, heading in; 1 if any lie on a plane."""
        lies = 0
        self.footing.lose(b)
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
        x, y, z, u, v, w, fate = self.events[g].entered(p, self.state(b, lane), self.fate(g, b, lane), True)
        self.put(g, b, lane, [x, y, z, u, v, w], fate)
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
                if (lane != NONE) | (self.footing.resting[b].max() > 0) | self._meets(g, p, b):
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
        old, new = [self.ending.base[c, b][lane] for c in ti.static(range(6))], self.state(b, lane)
        resting, forward = (
            self.footing.resting[b][lane],
            [self.footing.sliding[c, b][lane] for c in ti.static(range(3))],
        )
        first, due, near = self.events[g].first_event(p, old, new, resting, forward, reach, target, tolerance)
        if resting != 0:
            first, due, near = self.footing.released(g, p, b, lane, new, target, first, due, near)
        turn = self.events[g].turn(p, old, new, resting, reach)
        late = trial - reach
        return first, late + due, ti.select(near, 1, 0), late + turn

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
        x, y, z, u, v, w = self.state(b, lane)
        fate = self.fate(g, b, lane)
        stops = target == SLIDING_STOPS
        stalls = ti.select(quick, self.stalls[b][lane], 0)
        for k in ti.static(range(len(self.events[g].contacts))):
            q = p[self.events[g].first + k]
            height, margin = self.events[g].height(q, k, [x, y, z])
            speed = dot(self.events[g].contacts[k].normal(q), [u, v, w])
            near = (ti.abs(height) <= 4.0 * margin + tolerance * ti.abs(speed)) & (speed < 0.0)
            hit = (target == k) | (near & (rests_on(self.footing.resting[b][lane], k) == 0))
            x, y, z, u, v, w, fate = self.events[g].struck(q, k, [x, y, z, u, v, w], fate, hit)
            stalls = ti.select(hit, stalls + 1, stalls)
            stops = stops | (hit & (stalls >= 2 * MOST_STALLS))
            u, v, w = self.events[g].flattened(q, k, [u, v, w], hit & (stalls >= MOST_STALLS))
        self.stalls[b][lane] = stalls
        kept = ti.select(stops, 0.0, 1.0)
        self.put(g, b, lane, [x, y, z, kept * u, kept * v, kept * w], fate)

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
        x, y, z, u, v, w = self.state(b, lane)
        fate, kept = self.fate(g, b, lane), 1.0
        for _ in range(SWEEPS):
            for k in ti.static(range(len(self.events[g].contacts))):
                q = p[self.events[g].first + k]
                height, margin = self.events[g].height(q, k, [x, y, z])
                below = height < -margin
                x, y, z, u, v, w, fate = self.events[g].struck(q, k, [x, y, z, u, v, w], fate, below)
                kept = ti.select(below, 0.0, kept)
        self.put(g, b, lane, [x, y, z, kept * u, kept * v, kept * w], fate)

"""Coupled particles that rest on planes: what holds them in a step, and when forces draw them off."""

import taichi as ti

from particlecli.dynamics.algebra import dot
from particlecli.dynamics.contacts import TINY, length
from particlecli.dynamics.coupled.ending import Ending
from particlecli.dynamics.coupled.plane_lanes import PlaneLanes
from particlecli.dynamics.group_plan import LANES
from particlecli.dynamics.plane_events import NONE
from particlecli.dynamics.resting import rests_on

RELEASE = 32
"""With the number of a plane added: the event that forces cease to press a resting particle onto it."""

LOOSELY = 1e-6
"""Of the pressing at the beginning of a step: what may be left of it when a particle is let off. A kink in the
acceleration that is missed by a time δ is worth δ² in the velocity, so that need not be found any better."""


@ti.data_oriented
class Footing(PlaneLanes):
    """What particles rest on in a step, found out at its beginning.

    Args:
        ending: as of `PlaneLanes`.

    Attributes:
        resting: field of packs of bits: the planes that particles rest on in this step.
        sliding: field of packs, shape (4, packs): the direction in which they slide or are pulled, and the speed below
            which a velocity has no direction, m/s.
        pressing: field of packs, shape (planes, packs): what presses them onto each plane at the beginning, m/s².
        free: field of packs, shape (3, packs): accelerations as if there were no planes, m/s².
    """

    def __init__(self, ending: Ending) -> None:
        super().__init__(ending)
        pack = ti.types.vector(LANES, self.points.real)
        packs = self.points.capacity
        planes = max(len(self.events[g].contacts) for g in self.located)
        self.resting = ti.field(ti.types.vector(LANES, ti.i32), shape=packs)
        self.sliding, self.free = ti.field(pack, shape=(4, packs)), ti.field(pack, shape=(3, packs))
        self.pressing = ti.field(pack, shape=(planes, packs))

    @ti.func
    def lose(self, b):
        """Let pack b rest on nothing."""
        self.resting[b] = ti.Vector([0] * LANES)

    @ti.func
    def keep(self, b, a):
        """Keep accelerations as if there were no planes."""
        for c in ti.static(range(3)):
            self.free[c, b] = a[c]

    @ti.func
    def find(self, b, h):
        """Find out what pack b rests on in a step of length h, from the accelerations kept; 1 if it does."""
        rests = 0
        for g in ti.static(self.located):
            if self.points.holds(g, b):
                p = self.groups[g].loaded()
                for lane in range(LANES):
                    if self.ending.reaches[b][lane] > 0.0:
                        rests = ti.max(rests, self._find(g, p, b, lane, h))
        return rests

    @ti.func
    def _find(self, g: ti.template(), p, b, lane, h):
        state, a = self.state(b, lane), self._free(b, lane)
        resting, f0, f1, f2 = self.events[g].footing(p, state, a, h)
        if resting != 0:
            self.resting[b][lane] = resting
            grounded = self.events[g].grounded(p, state, resting)
            faint = self.events[g].faint * length(grounded[3:])
            for c in ti.static(range(4)):
                self.sliding[c, b][lane] = [f0, f1, f2, faint][c]
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
                        given = [ax[lane], ay[lane], az[lane]]
                        footing = [self.resting[b][lane]] + [self.sliding[c, b][lane] for c in ti.static(range(4))]
                        held = self.motions[g].held(p, self.state(b, lane), given, footing)
                        ax[lane], ay[lane], az[lane] = held[0], held[1], held[2]
        return [ax, ay, az]

    @ti.func
    def released(self, g: ti.template(), p, b, lane, state, target, first, due, near):
        """What `PlaneEvents.first_event` found, or that forces draw the particle off a plane before."""
        resting, reach = self.resting[b][lane], self.ending.reaches[b][lane]
        supported = self.motions[g].supported(p, state, self._free(b, lane), resting)
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
    def _free(self, b, lane):
        return [self.free[c, b][lane] for c in ti.static(range(3))]

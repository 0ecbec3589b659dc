"""What happens to coupled particles at the end of a step besides motion: contact, cooling, death, birth."""

from collections.abc import Sequence

import taichi as ti

from particlecli.dynamics.algebra import both, finite
from particlecli.dynamics.coupled.pins import Pins
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.deaths import Fate
from particlecli.dynamics.group import Group
from particlecli.dynamics.group_plan import LANES, Constant
from particlecli.dynamics.outcome import NOBODY

FAILED, DIED = range(2)
"""Places in the flags of a group: the first particle that is not finite, and whether any died."""


@ti.data_oriented
class Ending:
    """Brings packs from the end of the motion in a step to the end of the step.

    Args:
        groups: the coupled groups, in the order of `points.names`.
        points: all particles.
        base: field of packs, shape (6, packs): the state at the beginning of the step.

    Attributes:
        located: the places of the groups whose impacts have happened at their instants by then.
        reaches: length of the part of the step that each particle takes, s: all of it, what is left of it after
            birth, or nothing for those that do not move.
        pins: particles that forces do not move.
        needed: whether anything happens besides motion.
    """

    def __init__(self, groups: Sequence[Group], points: Points, base) -> None:
        self.groups = list(groups)
        self.points = points
        self.base = base
        self.pins = Pins([group.plan for group in groups], points)
        self.reaches = ti.field(ti.types.vector(LANES, points.real), shape=points.capacity)
        self.eventful = [bool(g.march.contacts or g.march.cools or g.has("fate") or g.has("age")) for g in groups]
        self.located = [g for g, group in enumerate(groups) if group.march.locates]
        self.needed = any(self.eventful)

    @ti.func
    def load(self, b):
        """Take a pack of points from the state of its group."""
        for g in ti.static(range(len(self.groups))):
            if self.points.holds(g, b):
                self._load(self.groups[g], g, b)

    @ti.func
    def _load(self, group: ti.template(), g: ti.template(), b):
        own = b - self.points.firsts[g]
        held = self._held(g, own)
        for c in ti.static(range(6)):
            self.points.state[c, b] = ti.select(held, group.state.reals[c, own], 0.0)
        self._act(group, g, b, held, group.component("fate", own, 0), group.component("age", own, 0.0))

    @ti.func
    def check(self, b, flags: ti.template()):
        """Note in the row of flags of a pack's group who failed and whether any died."""
        for g in ti.static(range(len(self.groups))):
            if self.points.holds(g, b):
                self._check(self.groups[g], g, b, flags)

    @ti.func
    def _check(self, group: ti.template(), g: ti.template(), b, flags: ti.template()):
        own = b - self.points.firsts[g]
        sound = ti.select(finite(self.points.position(b) + self.points.velocity(b)), 1, 0)
        fate = 0 * sound + group.component("fate", own, 0)
        last = ti.min(self.points.counts[g] - own * LANES, LANES)
        if (sound.min() == 0) | (fate.max() > 0):
            for lane in range(last):
                if fate[lane] > 0:
                    flags[g, DIED] = 1
                elif sound[lane] == 0:
                    ti.atomic_min(flags[g, FAILED], own * LANES + lane)

    @ti.func
    def store(self, b, interval, flags: ti.template()):
        """Put a pack back into the state of its group after an interval, s; not if any particle failed."""
        sound = True
        for g in ti.static(range(len(self.groups))):
            sound = sound & (flags[g, FAILED] == NOBODY)
        for g in ti.static(range(len(self.groups))):
            if self.points.holds(g, b) & sound:
                self._store(self.groups[g], b - self.points.firsts[g], b, interval)

    @ti.func
    def _store(self, group: ti.template(), own, b, interval):
        for c in ti.static(range(6)):
            group.state.reals[c, own] = self.points.state[c, b]
        if ti.static(group.has("age")):
            group.state.reals[group.state.row("age"), own] = group.component("age", own, 0.0) + interval

    @ti.func
    def begin(self, b, now, h):
        """Work out how far the particles of a pack go in a step from `now`, s since the frame began."""
        for g in ti.static(range(len(self.groups))):
            if self.points.holds(g, b):
                self._begin(self.groups[g], g, b, now, h)

    @ti.func
    def _begin(self, group: ti.template(), g: ti.template(), b, now, h):
        own = b - self.points.firsts[g]
        reach = 0.0 * self.points.mass[b] + h
        if ti.static(group.has("age")):
            reach = ti.min(ti.max(group.component("age", own, 0.0) + (now + h), 0.0), h)
        moves = self._held(g, own)
        if ti.static(group.has("fate")):
            moves = moves & (group.component("fate", own, 0) == int(Fate.ALIVE))
        if ti.static(self.pins.exist[g]):
            moves = moves & self.pins.free(g, own)
        self.reaches[b] = ti.select(moves, reach, 0.0)

    @ti.func
    def finish(self, b, t0, now, h):
        """Let a pack meet planes, cool, die, and begin to act on others once born; times as of `Step.begin`."""
        for g in ti.static([g for g, eventful in enumerate(self.eventful) if eventful]):
            if self.points.holds(g, b):
                self._finish(self.groups[g], g, b, t0, now, h)

    @ti.func
    def _finish(self, group: ti.template(), g: ti.template(), b, t0, now, h):
        own = b - self.points.firsts[g]
        p = group.loaded()
        reach = self.reaches[b]
        age = group.component("age", own, 0.0) + (now + h)
        x, y, z, u, v, w, end = self._met(group.march, g, p, b, t0 + now + h, reach, group.component("fate", own, 0))
        rate = group.component("cooling_rate", own, p[-1][Constant.COOLING_RATE])
        warmth = group.march.cooled(p, group.component("temperature", own, 0.0), rate, reach)
        lifetime = group.component("lifetime", own, p[-1][Constant.LIFETIME])
        end = group.march.judged(p[-1], end, [x, y, z], age, lifetime, warmth, reach)
        for c in ti.static(range(6)):
            self.points.state[c, b] = [x, y, z, u, v, w][c]
        if ti.static(group.march.cools):
            group.state.reals[group.state.row("temperature"), own] = warmth
        if ti.static(group.has("fate")):
            group.state.integers[group.state.row("fate"), own] = end
        self._act(group, g, b, self._held(g, own), end, age)

    @ti.func
    def _met(self, march: ti.template(), g: ti.template(), p, b, t, reach, fate):
        """Six packs of state and the fate after meeting the planes at time t, s."""
        before = [self.base[c, b] for c in ti.static(range(6))]
        x, y, z = self.points.state[0, b], self.points.state[1, b], self.points.state[2, b]
        u, v, w = self.points.state[3, b], self.points.state[4, b], self.points.state[5, b]
        gained = [u - before[3], v - before[4], w - before[5]]
        end = fate
        for k in ti.static(range(0 if g in self.located else len(march.contacts))):
            live = both(end == int(Fate.ALIVE) if ti.static(march.has_fate) else True, reach > 0.0)
            x, y, z, u, v, w, end = march.contacts[k].respond(
                p[march.first_contact + k], [x, y, z, u, v, w], before, gained, end, live, t, reach
            )
        return [x, y, z, u, v, w, end]

    @ti.func
    def _act(self, group: ti.template(), g: ti.template(), b, held, fate, age):
        """Give those of a pack their masses that act on others: the living that have been born."""
        own = b - self.points.firsts[g]
        acts = held
        if ti.static(group.has("fate")):
            acts = acts & (fate <= 0)
        if ti.static(group.has("age")):
            acts = acts & (age >= 0.0)
        # The constants of a group stand at the end of its table, after the parameters of its terms.
        constant = group.table[group.spans[-1][0] + int(Constant.INVERSE_MASS)]
        inverse = ti.select(acts, group.component("inverse_mass", own, constant), 1.0)
        self.points.mass[b] = ti.select(acts, 1.0 / inverse, 0.0)

    @ti.func
    def _held(self, g: ti.template(), own):
        """Mask of the lanes of a group's pack that hold a particle."""
        lanes = ti.Vector(list(range(LANES)))
        return lanes + own * LANES < self.points.counts[g]

"""The steps of a frame for one pack of a group: motion, contact, cooling and causes of death, in registers."""

from enum import IntEnum

import taichi as ti

from particlecli.dynamics.algebra import both, choose, dot
from particlecli.dynamics.contacts import TINY, PlaneContact
from particlecli.dynamics.cooling import CoolingTerm
from particlecli.dynamics.deaths import Fate
from particlecli.dynamics.dips import may_dip
from particlecli.dynamics.group_plan import Constant, GroupPlan
from particlecli.dynamics.impact_record import ImpactRecord
from particlecli.dynamics.impacts import CarefulStepper
from particlecli.dynamics.integrators.base import ExplicitRungeKutta, Splitting
from particlecli.dynamics.integrators.steppers import stepper
from particlecli.dynamics.memory import FieldMemory
from particlecli.dynamics.motion import Motion


class Way(IntEnum):
    """How a march goes about planes whose impacts are located in time.

    FREELY: as if they were not there. CALMLY: resting and sliding on them, as long as nothing else happens.
    CAREFULLY: from event to event.
    """

    FREELY = 0
    CALMLY = 1
    CAREFULLY = 2


@ti.data_oriented
class March:
    """Takes packs through the steps of a frame.

    Planes with impacts located in time are met on a second march: the first one goes as if they were not there and
    notes the lowest height above them; only particles that came below a plane march again: calmly where they rest all
    the time, else carefully.

    Attributes:
        terms: all that has parameters, in the order of the parameter lists handed to the kernels; the group's
            constants come last.
        locates: whether there are planes whose impacts are located in time.
        calms: whether packs may go calmly: implicit schemes and closed forms take particles one by one anyway.
    """

    def __init__(self, plan: GroupPlan, motion: Motion, real, record: ImpactRecord | None, memory: FieldMemory) -> None:
        self.plan = plan
        self.motion = motion
        self.contacts = [
            PlaneContact(plane, plan.newtonian, ride) for plane, ride in zip(plan.planes, plan.rides, strict=True)
        ]
        self.cooling = None if plan.cooling is None else CoolingTerm(plan.cooling, plan.hottest, plan.dt)
        self.terms = [*motion.terms(), *self.contacts, *([self.cooling] if self.cooling else [])]
        self.first_contact = len(motion.terms())
        self.stepper = stepper(plan.scheme, motion, real, memory)
        self.locates = plan.impacts == "located"
        self.careful_stepper = CarefulStepper(plan, motion, self.contacts, self.first_contact, real, record, memory)
        self.calms = self.locates and isinstance(plan.scheme, (ExplicitRungeKutta, Splitting))
        self.cools = self.cooling is not None
        self.has_fate = "fate" in plan.components
        self.is_born = "age" in plan.components
        self.bears_at_death = plan.bears_at_death
        self.dies_cold = plan.dies.colder_than is not None
        self.dies_outside = plan.dies.outside is not None

    @ti.func
    def advance(self, p, t0, dt, steps, state, own, fate, temperature, way: ti.template()):
        """The pack after all steps, and its lowest height above the planes at the end of any step.

        Of a calm march that height is that of steps in which something happened.

        Args:
            p: parameter lists of `terms`, then the constants.
            t0: time at the beginning, s.
            dt: length of a step, s.
            steps: how many.
            state: packs x, y, z, u, v, w; the last three idle in a first-order group.
            own: what does not change: age at the beginning, lifetime, rate of cooling, inverse mass; of single
                particles also the slot.
            fate, temperature: packs, or idle scalars where the group has none.
            way: how to go about planes; see `Way`.

        Returns:
            x, y, z, u, v, w, fate, temperature, lowest height, and the age at the end or at death, idle where no
            death bears children.
        """
        x, y, z, u, v, w = state[0], state[1], state[2], state[3], state[4], state[5]
        end, warmth = fate, temperature
        lowest, aged = 0.0 * x, 0.0 * x
        for s in range(steps):
            late, h = self._span(own, s, dt)
            t = t0 + (s * dt + late)
            was = end
            nx, ny, nz, nu, nv, nw, end = self._moved(p, [x, y, z, u, v, w], t, h, own, end, way)
            moving = self._moving(was, h)
            if ti.static(self.locates and way != Way.CAREFULLY):
                reached = self._reach(p, [x, y, z, u, v, w], [nx, ny, nz, nu, nv, nw], h)
                if ti.static(way == Way.CALMLY):
                    held, calm = self.careful_stepper.undisturbed(p, [x, y, z, u, v, w], t, h, own)
                    holds = calm & (reached < 0.0)
                    nx, ny, nz = choose(holds, held[0], nx), choose(holds, held[1], ny), choose(holds, held[2], nz)
                    nu, nv, nw = choose(holds, held[3], nu), choose(holds, held[4], nv), choose(holds, held[5], nw)
                    reached = ti.select(holds, 0.0, reached)
                lowest = ti.select(both(moving, reached < lowest), reached, lowest)
            x, y, z = choose(moving, nx, x), choose(moving, ny, y), choose(moving, nz, z)
            u, v, w = choose(moving, nu, u), choose(moving, nv, v), choose(moving, nw, w)
            warmth = self.cooled(p, warmth, own[2], h)
            if ti.static(self.bears_at_death):
                aged = ti.select(was <= 0, self._reached(own, s, dt), aged)
            end = self.judged(p[-1], end, [x, y, z], own[0] + (s + 1) * dt, own[1], warmth, h)
        return [x, y, z, u, v, w, end, warmth, lowest, aged]

    def _moving(self, fate, h):
        """Mask of the particles that take part in a step of length h: neither dead, nor stuck, nor unborn."""
        alive = fate == int(Fate.ALIVE) if self.has_fate else True
        return both(alive, self._born(h))

    def _born(self, h):
        return h > 0.0 if self.is_born else True

    @ti.func
    def _span(self, own, s, dt):
        """The part of step s that a particle takes: how late it begins in it, and how long it is.

        It is all of it, or what is left of it after its birth; where a death bears children, until its lifetime ends.
        """
        if ti.static(self.bears_at_death):
            before = own[0] + s * dt
            return ti.max(-before, 0.0), ti.max(self._reached(own, s, dt) - ti.max(before, 0.0), 0.0)
        if ti.static(self.is_born):
            h = ti.min(ti.max(own[0] + (s + 1) * dt, 0.0), dt)
            return dt - h, h
        return 0.0, dt

    @ti.func
    def _reached(self, own, s, dt):
        """The age at the end of step s, at most the lifetime."""
        age = own[0] + (s + 1) * dt
        if ti.static(self.plan.mortal):
            age = ti.min(age, own[1])
        return age

    @ti.func
    def _reach(self, p, before, after, h):
        """The lowest height above the planes at the end of a step; below zero too where one may be crossed within."""
        lowest = 0.0 * before[0]
        for k in ti.static(range(len(self.contacts))):
            q = p[self.first_contact + k]
            n = ti.static(self.contacts[k].normal(q))
            height = dot(n, after[:3]) - q[3]
            dips = may_dip(dot(n, before[:3]) - q[3], dot(n, before[3:]), height, dot(n, after[3:]), h)
            lowest = ti.min(lowest, ti.select(dips, ti.min(height, -TINY), height))
        return lowest

    @ti.func
    def _moved(self, p, state, t, h, own, fate, way: ti.template()):
        """Six packs of state and the fate after a step."""
        x, y, z, u, v, w = self.stepper.step(p, state, t, h, [own[3]])
        if ti.static(way == Way.CAREFULLY):
            return self.met(p, state, [x, y, z, u, v, w], t, h, own, fate, self._moving(fate, h))
        end = fate
        if ti.static(not self.locates):
            gained = [u - state[3], v - state[4], w - state[5]]
            for k in ti.static(range(len(self.contacts))):
                x, y, z, u, v, w, end = self.contacts[k].respond(
                    p[self.first_contact + k], [x, y, z, u, v, w], state, gained, end, self._moving(end, h), t + h, h
                )
        return [x, y, z, u, v, w, end]

    @ti.func
    def met(self, p, before, after, t, h, own, fate, live: ti.template()):
        """State and fate of a single particle after a step that may have met planes."""
        x, y, z, u, v, w = after[0], after[1], after[2], after[3], after[4], after[5]
        end = fate
        if ti.static(self.locates):
            lowest = self._reach(p, before, after, h)
            if both(live, lowest < 0.0):
                x, y, z, u, v, w, end = self.careful_stepper.step(p, before, t, h, own, fate, live)
        else:
            gained = [u - before[3], v - before[4], w - before[5]]
            for k in ti.static(range(len(self.contacts))):
                x, y, z, u, v, w, end = self.contacts[k].respond(
                    p[self.first_contact + k], [x, y, z, u, v, w], before, gained, end, self._moving(end, h), t + h, h
                )
        return [x, y, z, u, v, w, end]

    @ti.func
    def cooled(self, p, temperature, rate, h):
        """The temperature after a time h, K."""
        if ti.static(self.cools):
            return self.cooling.step(p[-2], temperature, rate, h)
        return temperature

    @ti.func
    def judged(self, c, fate, x, age, lifetime, temperature, h):
        """Fates after a step; of several causes in one step the first here counts."""
        if ti.static(not self.has_fate):
            return fate
        judged = fate
        if ti.static(self.plan.mortal):
            judged = ti.select((judged <= 0) & (age >= lifetime), int(Fate.EXPIRED), judged)
        if ti.static(self.dies_cold):
            judged = ti.select((judged <= 0) & (temperature < c[Constant.COLDEST]), int(Fate.COLD), judged)
        if ti.static(self.dies_outside):
            out = (x[0] < c[Constant.BOX]) | (x[0] > c[Constant.BOX + 3])
            for i in ti.static(range(1, 3)):
                out = out | (x[i] < c[Constant.BOX + i]) | (x[i] > c[Constant.BOX + 3 + i])
            judged = ti.select((judged <= 0) & out, int(Fate.OUTSIDE), judged)
        return choose(self._born(h), judged, fate)

    @ti.func
    def cooling_rate(self, p, temperature, rate):
        """dT/dt, K/s."""
        if ti.static(self.cools):
            return self.cooling.rate_of_change(p[-2], temperature, rate)
        return temperature * 0.0

"""What happens to particles at planes within a step, and when: impacts, turns above them, rest, the end of sliding."""

import math

import taichi as ti

from particlecli.dynamics.algebra import add, both, bound, dot, mul
from particlecli.dynamics.contacts import TINY, PlaneContact, length, tangential
from particlecli.dynamics.dips import lowest_at, may_dip
from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.resting import rests_on

MOST_STALLS = 60
"""Impacts of a particle in a row with hardly any time between them after which it no longer bounces; after twice as
many, as in a corner, it stops."""

NARROWEST = 1e-3
"""A lowest point nearer to an end of a trial than this share of it is the end."""

NONE = -1
SLIDING_STOPS = -2
"""What a lane is searching for: nothing, the end of its sliding, or (0, 1, …) the impact on that plane."""


@ti.data_oriented
class PlaneEvents:
    """The planes that particles of a group meet, as seen from within a step. States are six packs or six numbers.

    Args:
        plan: what the group needs.
        contacts: its planes.
        first_contact: where their parameters begin in the parameter lists `p` of the methods.

    Attributes:
        rounding: how exactly heights are known, relative to the coordinates.
        faint: the share of its speed at which a sliding particle that stops has no direction of its own any more; the
            way that is left then is within rounding.
        tolerance: how exactly instants are found, relative to the step.
        instant: events so near each other, relative to the step, have hardly any time between them.
        rest_time: bouncing that would go on for less than so many steps is rest. Schemes of first order need
            it long: what they err in a step would keep a particle bouncing for ever.
    """

    def __init__(self, plan: GroupPlan, contacts: list[PlaneContact], first_contact: int) -> None:
        single = plan.real_bytes == 4
        self.contacts = contacts
        self.first = first_contact
        self.rounding = 5e-7 if single else 1e-15
        self.faint = math.sqrt(self.rounding)
        self.tolerance = 1e-5 if single else 1e-12
        self.instant = 1e-3 if single else 1e-6
        self.rest_time = 4.0 if plan.scheme.order == 1 else 1e-2 if single else 1e-8
        self.slides = any(contact.coulomb and contact.friction > 0 for contact in contacts)

    @ti.func
    def lies(self, p, x):
        """Mask of the particles at positions x that lie on a plane, as far as rounding can tell."""
        near = x[0] != x[0]
        for k in ti.static(range(len(self.contacts))):
            height, margin = self.height(p[self.first + k], k, x)
            near = near | (ti.abs(height) <= 8.0 * margin)
        return near

    @ti.func
    def entered(self, p, state, fate, live: ti.template()):
        """State and fate with particles that begin the step below a plane, heading in, struck by it at once."""
        x, y, z, u, v, w, outcome = state[0], state[1], state[2], state[3], state[4], state[5], fate
        for k in ti.static(range(len(self.contacts))):
            hit = both(live, self.enters(p[self.first + k], k, [x, y, z, u, v, w]))
            x, y, z, u, v, w, outcome = self.struck(p[self.first + k], k, [x, y, z, u, v, w], outcome, hit)
        return [x, y, z, u, v, w, outcome]

    @ti.func
    def enters(self, p, k: ti.template(), state):
        """Whether particles are below plane k and head into it."""
        height, margin = self.height(p, k, state[:3])
        return (height < -margin) & (dot(self.contacts[k].normal(p), state[3:]) < 0.0)

    @ti.func
    def height(self, p, k: ti.template(), x):
        """Height above plane k, and how far rounding lets it be from the true one, both in m."""
        n = ti.static(self.contacts[k].normal(p))
        extent = dot([abs_of(c) for c in n], [ti.abs(c) for c in x])
        return dot(n, x) - p[3], self.rounding * (extent + ti.abs(p[3]))

    @ti.func
    def footing(self, p, state, a, h):
        """Bits of the planes that particles rest on, and the direction in which they slide or are pulled.

        Args:
            p, state: of particles, at the beginning of a step of length h.
            a: their accelerations as if there were no planes, m/s².
        """
        resting = ti.select(state[0] == state[0], 0, 0)
        g0, g1, g2, m0, m1, m2 = state[3], state[4], state[5], 0.0 * state[0], 0.0 * state[0], 0.0 * state[0]
        m0, m1, m2 = m0 + a[0], m1 + a[1], m2 + a[2]
        for k in ti.static(range(len(self.contacts))):
            if ti.static(self.contacts[k].bounces):
                q = p[self.first + k]
                n = ti.static(self.contacts[k].normal(q))
                height, margin = self.height(q, k, state[:3])
                speed, pressing = dot(n, state[3:]), -dot(n, a)
                soon_over = 2.0 * ti.abs(speed) <= pressing * self.rest_time * h * (1.0 - q[4])
                too_low = speed * speed <= 8.0 * margin * pressing
                slack = 16.0 * self.rounding * length(state[3:])
                rests = (
                    (ti.abs(height) <= 8.0 * margin)
                    & (pressing > 0.0)
                    & (soon_over | too_low | (ti.abs(speed) <= slack))
                )
                resting |= ti.select(rests, 1 << k, 0)
                flat, bare = tangential(n, [g0, g1, g2]), tangential(n, [m0, m1, m2])
                g0, g1, g2 = (
                    ti.select(rests, flat[0], g0),
                    ti.select(rests, flat[1], g1),
                    ti.select(rests, flat[2], g2),
                )
                m0, m1, m2 = (
                    ti.select(rests, bare[0], m0),
                    ti.select(rests, bare[1], m1),
                    ti.select(rests, bare[2], m2),
                )
        speed, pull = length([g0, g1, g2]), length([m0, m1, m2])
        slides = speed > 0.0
        return [
            resting,
            ti.select(slides, g0 / (speed + TINY), m0 / (pull + TINY)),
            ti.select(slides, g1 / (speed + TINY), m1 / (pull + TINY)),
            ti.select(slides, g2 / (speed + TINY), m2 / (pull + TINY)),
        ]

    @ti.func
    def grounded(self, p, state, resting):
        """States without what rounding has added across the planes that particles rest on."""
        x, y, z, u, v, w = state[0], state[1], state[2], state[3], state[4], state[5]
        for k in ti.static(range(len(self.contacts))):
            q = p[self.first + k]
            n = ti.static(self.contacts[k].normal(q))
            height, margin = self.height(q, k, [x, y, z])
            rests = rests_on(resting, k)
            off = ti.select(rests & (ti.abs(height) > margin), height, 0.0)
            away = ti.select(rests, dot(n, [u, v, w]), 0.0)
            x, y, z = [bound(add([x, y, z][c], mul(n[c], -off))) for c in ti.static(range(3))]
            u, v, w = [bound(add([u, v, w][c], mul(n[c], -away))) for c in ti.static(range(3))]
        return [x, y, z, u, v, w]

    @ti.func
    def first_event(self, p, old, new, resting, forward, trial, target, instant):
        """The event that comes first within a trial step, when it is due, and whether the trial ends near it.

        Where nothing happened within the trial, the latter two are about the event being searched. `instant` is the
        time by which the trial may miss it.
        """
        first = ti.select(trial == trial, NONE, NONE)
        due, soonest, near = trial, trial * 0.0 + 1e30, first == 0
        for k in ti.static(range(len(self.contacts))):
            q = p[self.first + k]
            height, margin = self.height(q, k, new[:3])
            start, _ = self.height(q, k, old[:3])
            speed = dot(self.contacts[k].normal(q), new[3:])
            when = ti.select(speed < 0.0, trial - height / ti.min(speed, -TINY), -1.0)
            happens = (height < -margin) & (start >= -8.0 * margin) & (rests_on(resting, k) == 0)
            earlier = happens & (when < soonest)
            concerns = earlier | ((first == NONE) & (target == k) & (happens == 0))
            first = ti.select(earlier, k, first)
            soonest = ti.select(earlier, when, soonest)
            due = ti.select(concerns, when, due)
            near = ti.select(concerns, ti.abs(height) <= 4.0 * margin + instant * ti.abs(speed), near)
        if ti.static(self.slides):
            start, speed = dot(old[3:], forward), dot(new[3:], forward)
            sliding = (resting != 0) & (start > 0.0)
            when = trial * start / (start - speed + TINY)
            earlier = sliding & (speed < 0.0) & (when < soonest)
            concerns = earlier | ((first == NONE) & (target == SLIDING_STOPS))
            first = ti.select(earlier, SLIDING_STOPS, first)
            due = ti.select(concerns, when, due)
            near = ti.select(concerns, ti.abs(speed) <= 4.0 * self.tolerance * start, near)
        return [first, due, near]

    @ti.func
    def turn(self, p, old, new, resting, trial):
        """When particles that head into a plane at first and away from it in the end are lowest; else the whole trial.

        That is looked at where they may have been below it between. A trial that ends there meets the plane or not.
        """
        first = trial
        for k in ti.static(range(len(self.contacts))):
            q = p[self.first + k]
            n = ti.static(self.contacts[k].normal(q))
            before, margin = self.height(q, k, old[:3])
            after, _ = self.height(q, k, new[:3])
            falling, rising = dot(n, old[3:]), dot(n, new[3:])
            when = lowest_at(before, falling, after, rising, trial)
            crosses = may_dip(before, falling, after, rising, trial) & (rests_on(resting, k) == 0)
            within = (when > NARROWEST * trial) & (when < (1.0 - NARROWEST) * trial) & (before > 8.0 * margin)
            first = ti.select(crosses & within, ti.min(first, when), first)
        return first

    @ti.func
    def struck(self, p, k: ti.template(), state, fate, hit):
        """State and fate after plane k is hit by those in the mask `hit`, which are put exactly onto it."""
        n = ti.static(self.contacts[k].normal(p))
        height, speed = dot(n, state[:3]) - p[3], dot(n, state[3:])
        placed = [bound(add(state[c], mul(n[c], -height))) for c in ti.static(range(3))]
        if ti.static(self.contacts[k].bounces):
            impulse = -(1.0 + p[4]) * speed
            turned = [bound(add(state[c + 3], mul(n[c], impulse))) for c in ti.static(range(3))]
            slowed = self.contacts[k].rubbed(p, n, turned, impulse)
            return _where(hit, placed + slowed, state) + [fate]
        return _where(hit, placed + [0.0, 0.0, 0.0], state) + [ti.select(hit, self.contacts[k].outcome, fate)]

    @ti.func
    def flattened(self, p, k: ti.template(), v, chosen):
        """Velocities v without what leads across plane k, in the mask `chosen`."""
        n = ti.static(self.contacts[k].normal(p))
        across = ti.select(chosen, dot(n, v), 0.0)
        return [bound(add(v[c], mul(n[c], -across))) for c in ti.static(range(3))]


def abs_of(c):
    """|c| of a literal or a value in the kernel."""
    return abs(c) if isinstance(c, float) else ti.abs(c)


def _where(mask, a, b):
    return [bound(ti.select(mask, a[c], b[c])) for c in range(6)]

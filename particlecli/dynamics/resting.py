"""Rest and friction on planes: the equations of motion of particles that planes hold."""

import taichi as ti

from particlecli.dynamics.algebra import add, bound, dot, mul
from particlecli.dynamics.contacts import TINY, PlaneContact, length, tangential
from particlecli.dynamics.matrices import ZERO, isotropic, outer, total
from particlecli.dynamics.vectors import difference, scaled

NOTHING = (0.0, 0.0, 0.0)


@ti.data_oriented
class RestingMotion:
    """Equations of motion of particles that may rest on planes.

    On each plane a particle rests on, the acceleration that presses it down is cancelled. Coulomb friction takes μ
    times it from the sliding, or holds what does not slide as long as that suffices; viscous friction takes k times
    it times the velocity.
    """

    def __init__(self, motion, contacts: list[PlaneContact], first_contact: int) -> None:
        self.motion = self.free = motion
        self.contacts = contacts
        self.first = first_contact
        self.first_order = motion.first_order

    @ti.func
    def derivative(self, p, state, t, body):
        """As `Motion.derivative` for a `body` that planes may hold.

        Friction keeps acting against the sliding direction when the sliding turns back within a step, or is too slow
        for its direction to be more than rounding: then the instant at which it stops is a simple root.

        Args:
            body: inverse mass, bits of the planes rested on, three components of the sliding direction, and the speed
                below which a velocity has no direction, m/s.
        """
        slope = self.motion.derivative(p, state, t, body[:1])
        return state[3:] + self.held(p, state, slope[3:], body[1:])

    @ti.func
    def held(self, p, state, a, footing):
        """Accelerations of particles that planes may hold, from those that they had if there were no planes.

        Args:
            p, state: of the particles.
            a: the accelerations, m/s².
            footing: as of `derivative`, without the inverse mass.
        """
        supported = self.supported(p, state, a, footing[0])
        a0, a1, a2 = supported[0], supported[1], supported[2]
        for k in ti.static(range(len(self.contacts))):
            a0, a1, a2 = self._rubbed(p[self.first + k], k, state, [a0, a1, a2], supported[3 + k], footing[1:])
        return [a0, a1, a2]

    def jacobian(self, p, state, t, body):
        """As `Motion.jacobian`, for a `body` as that of `derivative`."""
        by_position, by_velocity = self.motion.jacobian(p, state, t, body[:1])
        slope = self.motion.derivative(p, state, t, body[:1])
        pressed = self.supported(p, state, slope[3:], body[1])[3:]
        for k in range(len(self.contacts)):
            q = p[self.first + k]
            rubbing, sliding = self._friction(q, k, state, pressed[k], body[2:])
            by_position = self._relieved(q, k, by_position, rubbing, pressed[k])
            by_velocity = total([self._relieved(q, k, by_velocity, rubbing, pressed[k]), sliding])
        return by_position, by_velocity

    @ti.func
    def supported(self, p, state, a, resting):
        """Accelerations `a` without what presses onto the planes rested on, and that part by plane, as sizes."""
        a0, a1, a2 = a[0] + 0.0 * state[0], a[1] + 0.0 * state[0], a[2] + 0.0 * state[0]
        pressed = [bound(0.0 * state[0]) for _ in ti.static(range(len(self.contacts)))]
        for _ in range(1 if ti.static(len(self.contacts) == 1) else 6):
            for k in ti.static(range(len(self.contacts))):
                n = ti.static(self.contacts[k].normal(p[self.first + k]))
                against = ti.select(rests_on(resting, k), ti.max(-dot(n, [a0, a1, a2]), 0.0), 0.0)
                a0, a1, a2 = (
                    add(a0, mul(n[0], against)),
                    add(a1, mul(n[1], against)),
                    add(a2, mul(n[2], against)),
                )
                pressed[k] += against
        return [a0, a1, a2] + pressed

    @ti.func
    def _rubbed(self, p, k: ti.template(), state, a, pressed, forward):
        if ti.static(self.contacts[k].friction == 0.0):
            return a
        n = ti.static(self.contacts[k].normal(p))
        v = tangential(n, state[3:])
        if ti.static(not self.contacts[k].coulomb):
            return [a[c] - p[5] * pressed * v[c] for c in ti.static(range(3))]
        pull = tangential(n, a)
        speed, pulling = length(v), length(pull)
        moves = (speed > 0.0) | (forward[3] > 0.0)
        onward = dot(v, forward[:3]) > forward[3]
        taken = p[5] * pressed
        holds = (moves == 0) & (pulling <= taken) & (pressed > 0.0)
        along = [
            ti.select(moves, ti.select(onward, v[c] / (speed + TINY), forward[c]), pull[c] / (pulling + TINY))
            for c in ti.static(range(3))
        ]
        return [ti.select(holds, 0.0, a[c] - taken * along[c]) for c in ti.static(range(3))]

    def _relieved(self, p, k, matrix, rubbing, pressed):
        """A derivative of the acceleration without what plane k takes of it.

        Args:
            p: parameters of the plane.
            k: its number.
            matrix: the derivative without it.
            rubbing: acceleration by friction, by the pressing.
            pressed: acceleration that presses onto it, as a size.
        """
        n = self.contacts[k].normal(p)
        pressing = [dot(n, column) for column in zip(*matrix, strict=True)]
        share = bound(ti.select(pressed > 0.0, -1.0, 0.0))
        return total([matrix, outer(scaled(share, difference(n, rubbing)), pressing)])

    def _friction(self, p, k, state, pressed, forward):
        """The direction friction takes from, by the pressing, and the derivative of friction by the velocity."""
        contact = self.contacts[k]
        if contact.friction == 0.0:
            return NOTHING, ZERO
        n = contact.normal(p)
        v = tangential(n, state[3:])
        if not contact.coulomb:
            rate = bound(p[5] * pressed)
            return scaled(p[5], v), total([isotropic(-rate), outer(scaled(rate, n), n)])
        speed = length(v)
        onward = bound(dot(v, forward[:3]) > forward[3])
        along = [bound(ti.select(onward, v[c] / (speed + TINY), forward[c])) for c in range(3)]
        rate = bound(ti.select(onward, p[5] * pressed / (speed + TINY), 0.0))
        turning = total([isotropic(-rate), outer(scaled(rate, n), n), outer(scaled(rate, along), along)])
        return scaled(p[5], along), turning


def rests_on(resting, k):
    """Mask of the lanes that rest on plane k."""
    return (resting & (1 << k)) != 0

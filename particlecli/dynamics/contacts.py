"""Contact with planes at the end of a step: impact, rest, friction (Witkin & Baraff, Physically Based Modeling)."""

import taichi as ti

from particlecli.dynamics import vector_math
from particlecli.dynamics.algebra import add, both, bound, dot, mul
from particlecli.dynamics.deaths import Fate
from particlecli.dynamics.riding import applied, pose_and_rate, velocity_at
from particlecli.dynamics.vectors import structured
from particlecli.scene.frames import Chain
from particlecli.scene.planes import Coulomb, Plane

TINY = 1e-30
"""Keeps a division by a vanishing tangential speed finite; the quotient is then far above every bound it is held to."""

SHORTEST_REBOUND = 2.0
"""A rebound slower than so many times what the forces take from it in one step is rest: it would last four steps."""


@ti.data_oriented
class PlaneContact:
    """One plane as a group's kernel meets it.

    A particle hits when it is below the plane and heads into it. Its position is corrected along the normal and its
    normal velocity becomes −e times what it was. Where the rebound would be over in a few steps, it rests: the
    pressing force is cancelled and it stays on the plane. Friction takes from the tangential velocity at most μ times
    the normal impulse (Coulomb), or k times impulse times velocity (viscous); a resting particle that friction stops
    stays where it was. What happens on a plane that rides on a moving frame happens as seen from the plane.

    Args:
        plane: as in the scene.
        newtonian: whether the group that meets it has velocities.
        ride: the frames from the world to the one it rides on.
    """

    def __init__(self, plane: Plane, newtonian: bool, ride: Chain = ()) -> None:
        self.plane = plane
        self.ride = ride
        self.newtonian = newtonian
        self.coulomb = isinstance(plane.friction, Coulomb)
        self.friction = plane.friction.coulomb if isinstance(plane.friction, Coulomb) else plane.friction.viscous
        self.bounces = plane.on_hit == "bounce"
        self.outcome = int(Fate.PLANE if plane.on_hit == "die" else Fate.STUCK)

    def parameters(self) -> list[float]:
        """Values the kernel gets at run time: normal, offset, restitution, friction."""
        normal = self.plane.normal
        offset = sum(n * x for n, x in zip(normal, self.plane.point, strict=True))
        return [*normal, offset, self.plane.restitution, self.friction]

    def normal(self, p):
        """The normal, with components that are 0, 1 or −1 as literals."""
        if self.ride:
            return p[:3]
        return [n if n in (0.0, 1.0, -1.0) else p[i] for i, n in enumerate(self.plane.normal)]

    @ti.func
    def respond(self, p, state, before, gained, fate, live: ti.template(), t, h):
        """State and fate after meeting the plane at time t, the end of a step of length h.

        Args:
            p: this plane's parameters.
            state: [x, y, z, u, v, w] at the end of the step; the last three are idle in a first-order group.
            before: the same at its beginning.
            gained: velocity the forces added in the step, three packs.
            fate: fates, packs of integers (idle where nothing can die or stick).
            live: mask of the particles that move.
        """
        if ti.static(self.ride):
            q, drift, seen, ahead = ti.static(self._seen(p, state, before, t, h))
            x, y, z, u, v, w, end = self._respond(q, seen, ahead, gained, fate, live)
            return ti.static([x, y, z, add(u, drift[0]), add(v, drift[1]), add(w, drift[2]), end])
        return self._respond(p, state, before, gained, fate, live)

    def _seen(self, p, state, before, t, h):
        """From a plane that moves: its parameters, its drift where the particle is, the state, and where it was.

        A particle that rested on the plane was where the drift would have taken it.
        """
        here, rate = pose_and_rate(self.ride, t)
        normal = applied(here.rotation, structured(self.plane.normal, p))
        point = here.point(tuple(self.plane.point))
        drift = velocity_at(here, rate, state[:3]) if self.newtonian else (0.0, 0.0, 0.0)
        seen = [*state[:3], *(bound(add(v, mul(-1.0, d))) for v, d in zip(state[3:], drift, strict=True))]
        ahead = [bound(add(x, mul(h, d))) for x, d in zip(before[:3], drift, strict=True)]
        return [*normal, bound(dot(normal, point)), p[4], p[5]], drift, seen, ahead

    @ti.func
    def _respond(self, p, state, before, gained, fate, live: ti.template()):
        n = ti.static(self.normal(p))
        height = dot(n, state[:3]) - p[3]
        hit = both(live, height < 0.0)
        if ti.static(self.newtonian):
            speed = dot(n, state[3:])
            hit = hit & (speed < 0.0)
            if ti.static(self.bounces):
                return self._bounced(p, n, state, before, gained, hit, height, speed) + [fate]
            return self._held(n, state, hit, height) + [ti.select(hit, self.outcome, fate)]
        if ti.static(self.bounces):
            return _lifted(n, state, hit, height) + [fate]
        return _lifted(n, state, hit, height) + [ti.select(hit, self.outcome, fate)]

    @ti.func
    def _bounced(self, p, n: ti.template(), state, before, gained, hit, height, speed):
        rebound = -p[4] * speed
        rests = rebound <= -SHORTEST_REBOUND * dot(n, gained)
        impulse = ti.select(rests, 0.0, rebound) - speed
        lift = ti.select(rests, -height, -(1.0 + p[4]) * height)
        moved = [add(state[c], mul(n[c], lift)) for c in ti.static(range(3))]
        turned = [add(state[c + 3], mul(n[c], impulse)) for c in ti.static(range(3))]
        if ti.static(self.friction == 0.0):
            return [ti.select(hit, (moved + turned)[c], state[c]) for c in ti.static(range(6))]
        kept = self._kept(p, impulse, tangential(n, turned))
        slowed = self._slowed(n, turned, kept)
        stays = rests & (kept <= 0.0)
        start = dot(n, before[:3]) - p[3]
        placed = [ti.select(stays, before[c] - mul(n[c], start), moved[c]) for c in ti.static(range(3))]
        return [ti.select(hit, (placed + slowed)[c], state[c]) for c in ti.static(range(6))]

    @ti.func
    def rubbed(self, p, n: ti.template(), velocity, impulse):
        """The velocity that friction leaves after an impact of a normal impulse (by mass, m/s)."""
        if ti.static(self.friction == 0.0):
            return velocity
        return self._slowed(n, velocity, self._kept(p, impulse, tangential(n, velocity)))

    @ti.func
    def _slowed(self, n: ti.template(), velocity, kept):
        sliding = tangential(n, velocity)
        return [bound(velocity[c] - (1.0 - kept) * sliding[c]) for c in ti.static(range(3))]

    @ti.func
    def _kept(self, p, impulse, sliding):
        """The share of the sliding velocity that friction leaves."""
        if ti.static(self.coulomb):
            return ti.max(0.0, 1.0 - p[5] * impulse / (length(sliding) + TINY))
        return vector_math.exp(-p[5] * ti.max(impulse, 0.0))

    @ti.func
    def _held(self, n: ti.template(), state, hit, height):
        lifted = _lifted(n, state, hit, height)
        return lifted[:3] + [ti.select(hit, 0.0, state[c]) for c in ti.static(range(3, 6))]


def _lifted(n, state, hit, height):
    """Positions put back onto the plane where they hit, the rest of the state as it was."""
    return [ti.select(hit, add(state[c], mul(n[c], -height)), state[c]) for c in range(3)] + list(state[3:])


def tangential(n, v):
    """The part of a vector along a plane of normal n."""
    normal = bound(dot(n, v))
    return [bound(add(v[c], mul(-1.0, mul(n[c], normal)))) for c in range(3)]


def length(v):
    """Euclidean norm."""
    return bound(ti.sqrt(dot(v, v)))

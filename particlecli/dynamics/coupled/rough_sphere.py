"""Rough spheres: grains that stick to each other until they slip, so that heaps of them stand."""

from collections.abc import Sequence

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.local import LocalTerm
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.group_plan import LANES
from particlecli.scene import forces as scene

MOST = 16
"""Contacts of a grain that are remembered: twelve equal spheres touch one. Further ones have no memory."""

TINY = 1e-30
"""Keeps quotients by vanishing lengths finite."""


class RoughSphere(LocalTerm[scene.SoftSphere]):
    """F = N n + T, N = max(0, k (D − r) − γ v_n) where r < D, T = −k_t ξ − γ v_t, no longer than μ N.

    Symbols: as of `SoftSphere`; μ coefficient of friction; ξ how far a grain has slid along the other, m, since they
    touched, less what was lost in slipping, so that k_t |ξ| <= μ N; k_t = 2/7 k. Spheres do not turn.
    What is remembered of a contact is the offset at which ξ is zero. It begins when grains touch, and changes at the
    ends of steps; where particles die, or groups before theirs change, contacts begin anew.
    Source: Cundall & Strack, Géotechnique 29 (1979) 47; k_t after Silbert et al., Phys. Rev. E 64 (2001) 051302.
    """

    ends_steps = True

    def __init__(self, spec: scene.SoftSphere, points: Points, groups: Sequence[int]) -> None:
        super().__init__(spec, points, groups, spec.diameter, moves=True)
        slots = points.capacity * LANES
        self.contacts = ti.field(ti.i32, shape=slots)
        self._contacts = points.memory.view(self.contacts)
        self.partners = ti.field(ti.i32, shape=(slots, MOST))
        self.anchors = ti.Vector.field(3, points.real, shape=(slots, MOST))
        self._arranged = self._arrangement()

    def parameters(self) -> list[float]:
        """D², D, k, γ, μ, k_t."""
        spec = self.spec
        return [
            spec.diameter**2,
            spec.diameter,
            spec.stiffness,
            spec.damping,
            spec.friction,
            2.0 / 7.0 * spec.stiffness,
        ]

    def _arrangement(self) -> tuple[np.ndarray, np.ndarray]:
        groups = list(self.groups)
        return self.points.first_packs[groups], self.points.populations[groups]

    def rearranged(self) -> None:
        """Contacts hold if particles only came behind those that were there."""
        super().rearranged()
        firsts, populations = self._arrangement()
        if (firsts != self._arranged[0]).any() or (populations < self._arranged[1]).any():
            self.restart()
        self._arranged = firsts, populations

    def restart(self) -> None:
        """Forget all contacts."""
        self._contacts.array[:] = 0

    @ti.func
    def _pressing(self, p, distance, n, v):
        return ti.max(p[2] * (p[1] - distance) - p[3] * n.dot(v), 0.0)

    @ti.func
    def _pull(self, p, slot, partner, d, v):
        """The force on a grain by one that it may touch, N; the contact is remembered."""
        force = 0.0 * d
        distance2 = d.dot(d)
        if (distance2 < p[0]) & (distance2 > 0.0):
            distance = ti.sqrt(distance2)
            n = d / distance
            slid = d - self._anchor(slot, partner, d)
            rub = -p[5] * (slid - n.dot(slid) * n) - p[3] * (v - n.dot(v) * n)
            pressing = self._pressing(p, distance, n, v)
            force = pressing * n + ti.min(1.0, p[4] * pressing / (rub.norm() + TINY)) * rub
        return force

    @ti.func
    def _anchor(self, slot, partner, d):
        """Where the contact with a partner began; here and now if it is new."""
        place, known = 0, self.contacts[slot]
        while (place < known) & (self.partners[slot, ti.min(place, MOST - 1)] != partner):
            place += 1
        if (place == known) & (known < MOST):
            self.partners[slot, place] = partner
            self.anchors[slot, place] = d
            self.contacts[slot] = known + 1
        anchor = d
        if place < ti.min(known, MOST):
            anchor = self.anchors[slot, place]
        return anchor

    @ti.func
    def accelerate(self, rows: ti.template(), lists: ti.template(), b, worker):
        """Fill in the accelerations of the grains of a pack, one by one, see `over_packs`."""
        count, begins, ends, entries = ti.static(lists)
        first, stop = b * rows.width, ti.min((b + 1) * rows.width, count)
        for row in range(first, stop):
            force = 0.0 * self._position(rows, row)
            for other in range(first, stop):
                if other != row:
                    force += self._between(rows, row, other)
            for e in range(begins[b], ends[b]):
                force += self._between(rows, row, entries[e])
            mass = rows.at[row][3]
            self.accelerations[row] = ti.Vector([force[0] / mass, force[1] / mass, force[2] / mass, 0.0])

    @ti.func
    def _position(self, rows: ti.template(), row):
        at = rows.at[row]
        return ti.Vector([at[0], at[1], at[2]])

    @ti.func
    def _between(self, rows: ti.template(), row, other):
        here, there = rows.moving[row], rows.moving[other]
        v = ti.Vector([here[0] - there[0], here[1] - there[1], here[2] - there[2]])
        d = self._position(rows, row) - self._position(rows, other)
        return self._pull(self.loaded(), rows.order[row], rows.order[other], d, v)

    @ti.func
    def end_step(self, p, b, t):
        """Contacts that slipped begin later, and those that are over are forgotten."""
        for lane in range(LANES):
            slot, kept = b * LANES + lane, 0
            for place in range(self.contacts[slot]):
                partner = self.partners[slot, place]
                d = self._component(slot, 0) - self._component(partner, 0)
                v = self._component(slot, 3) - self._component(partner, 3)
                distance2 = d.dot(d)
                acts = self.points.mass[partner // LANES][partner % LANES] > 0.0
                if (distance2 < p[0]) & (distance2 > 0.0) & acts:
                    distance = ti.sqrt(distance2)
                    n = d / distance
                    slid = d - self.anchors[slot, place]
                    slid = slid - n.dot(slid) * n
                    most = p[4] * self._pressing(p, distance, n, v) / p[5]
                    self.partners[slot, kept] = partner
                    self.anchors[slot, kept] = d - ti.min(1.0, most / (slid.norm() + TINY)) * slid
                    kept += 1
            self.contacts[slot] = kept

    @ti.func
    def _component(self, slot, first):
        """A particle's position, or its velocity from the third row on."""
        b, lane = slot // LANES, slot % LANES
        return ti.Vector([self.points.state[first + c, b][lane] for c in ti.static(range(3))])

    @ti.func
    def force(self, p, d, distance2, here, there):
        """Grains are summed one by one, with what they remember: see `_pull`."""
        return [0.0, 0.0, 0.0, 0.0]

"""Particles that forces do not move: where they are, which stay and which go where they are told."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import taichi as ti

from particlecli.dynamics.birth_table import BirthTable
from particlecli.dynamics.coupled.courses import Course
from particlecli.dynamics.coupled.links import places
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.group_plan import LANES, GroupPlan
from particlecli.scene.groups import Pin
from particlecli.scene.poses import Poses


@ti.data_oriented
class Pins:
    """The pinned particles of coupled groups.

    Args:
        plans: of the groups of `points`, in their order.
        points: all particles.

    Attributes:
        exist: for each group, whether it has pinned particles.
        move: likewise, whether some of them go somewhere.
    """

    def __init__(self, plans: Sequence[GroupPlan], points: Points) -> None:
        self.points = points
        self.courses = [
            [Course(pin.path, ride) for pin, ride in zip(plan.pins, plan.pin_rides, strict=True)] for plan in plans
        ]
        self.exist = [bool(courses) for courses in self.courses]
        self.move = [any(course.moves for course in courses) for courses in self.courses]
        packs = [-(-plan.capacity // LANES) if exist else 0 for plan, exist in zip(plans, self.exist, strict=True)]
        self.first_rows = np.cumsum([0, *packs]).tolist()
        rows = max(1, sum(packs))
        self.numbers = ti.field(ti.types.vector(LANES, ti.i32), shape=rows)
        self.anchors = ti.field(ti.types.vector(LANES, points.real), shape=(3, rows))
        self._numbers = np.zeros((rows, LANES), np.int32)
        if any(self.exist):
            found = [_pinned(plan) for plan, exist in zip(plans, self.exist, strict=True) if exist]
            self._numbers = np.concatenate([numbers for numbers, _ in found])
            points.memory.view(self.numbers, self._numbers)
            points.memory.view(self.anchors, np.concatenate([anchors for _, anchors in found], axis=1))

    def pinned(self, g: int):
        """Which particles of group g are pinned, shape (16 packs,); of a group without pins none, shape (0,)."""
        first, last = self.first_rows[g : g + 2]
        return self._numbers[first:last].reshape(-1) != 0

    @ti.func
    def free(self, g: ti.template(), own):
        """Mask of the particles in pack `own` of group g that are not pinned."""
        return self.numbers[self.first_rows[g] + own] == 0

    @ti.func
    def place(self, b, t):
        """Bring the pinned particles of pack b to where they are at time t, s, and to their velocity there."""
        for g in ti.static([g for g, moves in enumerate(self.move) if moves]):
            if self.points.holds(g, b):
                own = self.first_rows[g] + b - self.points.firsts[g]
                x, y, z = self.anchors[0, own], self.anchors[1, own], self.anchors[2, own]
                for k in ti.static([k for k, course in enumerate(self.courses[g]) if course.moves]):
                    there = ti.static(self.courses[g][k].at((x, y, z), t, 0))
                    for c in ti.static(range(6)):
                        self.points.state[c, b] = ti.select(
                            self.numbers[own] == k + 1, there[c], self.points.state[c, b]
                        )

    @ti.func
    def slopes(self, b, t):
        """How fast positions and velocities of the pinned particles of pack b change, six packs; 0 where they stay."""
        zero = 0.0 * self.points.mass[b]
        du, dv, dw, dx, dy, dz = zero, zero, zero, zero, zero, zero
        for g in ti.static([g for g, moves in enumerate(self.move) if moves]):
            if self.points.holds(g, b):
                own = self.first_rows[g] + b - self.points.firsts[g]
                x, y, z = self.anchors[0, own], self.anchors[1, own], self.anchors[2, own]
                for k in ti.static([k for k, course in enumerate(self.courses[g]) if course.moves]):
                    rates = ti.static(self.courses[g][k].at((x, y, z), t, 1))
                    on = self.numbers[own] == k + 1
                    dx, dy, dz = (
                        ti.select(on, rates[0], dx),
                        ti.select(on, rates[1], dy),
                        ti.select(on, rates[2], dz),
                    )
                    du, dv, dw = (
                        ti.select(on, rates[3], du),
                        ti.select(on, rates[4], dv),
                        ti.select(on, rates[5], dw),
                    )
        return [dx, dy, dz, du, dv, dw]


def at_start(plan: GroupPlan, table: BirthTable) -> BirthTable:
    """Births at t = 0, the pinned ones where they are told to be, with their velocity."""
    if not any(map(_moves, plan.pins)):
        return table
    numbers, anchors = _pinned(plan)
    numbers, anchors = numbers.reshape(-1)[table.ids], anchors.reshape(3, -1)[:, table.ids]
    positions, velocities = table.positions.copy(), np.array(table.velocities)
    for number, (pin, ride) in enumerate(zip(plan.pins, plan.pin_rides, strict=True), start=1):
        if _moves(pin):
            chosen = numbers == number
            within, rate = _within(pin, anchors[:, chosen])
            pose = Poses.of(ride, np.zeros(1))
            positions[:, chosen] = pose.points(within)
            velocities[:, chosen] = pose.velocities(within) + pose.scale * pose.directions(rate)
    return replace(table, positions=positions, velocities=velocities)


def _moves(pin: Pin):
    return pin.path is not None or pin.frame is not None


def _within(pin: Pin, anchors):
    """Where particles are in the pin's frame at t = 0, and how fast they go there, shape (3, n)."""
    if pin.path is None:
        return anchors, np.zeros_like(anchors)
    names = {**dict(zip("xyz", anchors, strict=True)), "t": 0.0}
    rows = [[each.evaluate(names) for each in (component, component.derivative("t"))] for component in pin.path]
    places, rates = (np.stack([np.broadcast_to(row[k], anchors.shape[1:]) for row in rows]) for k in range(2))
    return places, rates


def _pinned(plan: GroupPlan):
    """The number of each particle's pin, counted from 1, or 0, shape (packs, 16); and its place, (3, packs, 16).

    The places are in the frames that the pins ride on, all at t = 0.
    """
    positions = plan.births.table(0, plan.births.total).positions
    count = positions.shape[1]
    s, side = places(plan.layout, count)
    names = {**dict(zip("xyz", positions, strict=True)), "s": s, "side": side}
    rows = -(-count // LANES) * LANES
    numbers, anchors = np.zeros(rows, np.int32), np.zeros((3, rows))
    anchors[:, :count] = positions
    for number, pin in reversed(list(enumerate(plan.pins, start=1))):
        chosen = np.flatnonzero(np.broadcast_to(pin.where.evaluate(names), count))
        numbers[chosen] = number
        anchors[:, chosen] = Poses.of(plan.pin_rides[number - 1], np.zeros(1)).local(positions[:, chosen])
    return numbers.reshape(-1, LANES), anchors.reshape(3, -1, LANES)

"""The laws of contact with planes as the judge knows them: written apart from the kernels, for exact flights.

A particle is free, rests or slides on one plane, or is stuck. Between events its motion is smooth; an event
is where a gap falls below zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from particlecli.accuracy.bodies import FREE, STUCK, Bodies, CannotJudgeError, Doubles, Mask, Slopes
from particlecli.scene.planes import Coulomb, Plane

ROUNDING = 4e-15
"""How exactly heights above a plane are known, relative to the coordinates they are made of."""

SLACK = 1e-12
"""By how much, relative to the acceleration, what holds a particle may seem to fail by rounding."""

REST = 1e-11
"""Bouncing that would go on for less than so many frames is rest."""

STILL = 1e-9
"""A speed that the acceleration gives in so many frames is none where sliding turns back."""

LONGEST_CHAIN = 100
"""Impacts at one instant that are followed."""


@dataclass(frozen=True)
class Ground:
    """The planes that a group meets, and its motion away from them.

    Attributes:
        planes: as in the scene.
        free: time derivatives of the states of bodies that touch nothing.
        interval: a frame, s.
    """

    planes: Sequence[Plane]
    free: Slopes
    interval: float

    def slopes(self, bodies: Bodies) -> Doubles:
        """Time derivatives of the states, of their shape: nothing presses through a plane, and friction acts on it."""
        slopes = self.free(bodies)
        for k, plane in enumerate(self.planes):
            there = bodies.on == k
            if there.any():
                slopes[:, there] = _on_plane(plane, bodies.rows(there), slopes[:, there])
        slopes[:, bodies.held | (bodies.on == STUCK)] = 0.0
        return slopes

    def gaps(self, bodies: Bodies) -> Doubles:
        """How far events are, shape (planes + 2, n): impacts, leaving a plane, the end of sliding or rest."""
        gaps = np.full((len(self.planes) + 2, len(bodies)), np.inf)
        raw = self.free(bodies) if (bodies.on >= 0).any() else None
        for k, plane in enumerate(self.planes):
            apart = (bodies.on != k) & (bodies.on != STUCK)
            gaps[k, apart] = (height(plane, bodies.x) + self._margin(plane, bodies))[apart]
            there = bodies.on == k
            if raw is not None and there.any():
                gaps[-2:, there] = _hold(plane, bodies.rows(there), raw[:, there])
        return gaps

    def delay(self, bodies: Bodies, event: NDArray[np.int64]) -> Doubles:
        """How long after the given times the events are, s, shape (n,), to first order; 0 where it does not matter."""
        slopes = self.slopes(bodies)
        delay = np.zeros(len(bodies))
        for k, plane in enumerate(self.planes):
            hit = (event == k) & (along(plane, slopes[:3]) < 0)
            delay[hit] = -height(plane, bodies.x[:, hit]) / along(plane, slopes[:3, hit])
        if len(slopes) == 6:
            slowing = (slopes[3:] * bodies.forward).sum(axis=0)
            stops = (event == len(self.planes) + 1) & ~bodies.held & (slowing < 0)
            delay[stops] = -(bodies.v * bodies.forward).sum(axis=0)[stops] / slowing[stops]
        return delay

    def settle(self, bodies: Bodies, turned: Mask | None = None) -> Mask:
        """Bring bodies where they touch planes to what follows: struck, sliding, held, stuck or free.

        Args:
            bodies: at their events; changed.
            turned: those whose sliding has just come to its end or turned.

        Returns:
            True for those that a plane has killed.
        """
        first_order = len(bodies.states) == 3
        if turned is not None and turned.any():
            pull = np.linalg.norm(self.free(bodies)[-3:], axis=0)
            slow = np.linalg.norm(bodies.v, axis=0) <= STILL * self.interval * pull
            bodies.states[3:, turned & slow] = 0.0
        killed = self._lay(bodies) if first_order else self._strike(bodies)
        loose = bodies.on != STUCK
        bodies.on[loose], bodies.held[loose] = FREE, False
        raw = self.free(bodies)
        for k, plane in enumerate(self.planes):
            if plane.on_hit == "bounce":
                rests = loose & ~killed & self._rests(plane, bodies, raw)
                if (bodies.on[rests] >= 0).any():
                    raise CannotJudgeError("a particle rests on two planes at once, which the judge cannot follow")
                bodies.on[rests] = k
                bodies.put(rests, _at_rest(plane, bodies.rows(rests), raw[:, rests]))
        return killed

    def _strike(self, bodies: Bodies) -> Mask:
        """Let bodies bounce off all planes they touch and head into; true for those that are killed."""
        killed = np.zeros(len(bodies), bool)
        for _ in range(LONGEST_CHAIN):
            again = False
            for k, plane in enumerate(self.planes):
                low = height(plane, bodies.x) <= self._margin(plane, bodies)
                inward = along(plane, bodies.v) < np.where(bodies.on == k, -self._noise(bodies), -self._nothing(bodies))
                hit = low & inward & (bodies.on != STUCK) & ~killed
                if not hit.any():
                    continue
                again = True
                bodies.x[:, hit] -= np.outer(plane.normal, height(plane, bodies.x[:, hit]))
                if plane.on_hit == "die":
                    killed |= hit
                elif plane.on_hit == "stick":
                    bodies.on[hit], bodies.v[:, hit] = STUCK, 0.0
                else:
                    bodies.on[hit] = FREE
                    bodies.v[:, hit] = _rebound(plane, bodies.v[:, hit])
            if not again:
                self._refuse_buried(bodies)
                return killed
        raise CannotJudgeError(f"a particle hits planes more than {LONGEST_CHAIN} times at one instant")

    def _margin(self, plane: Plane, bodies: Bodies) -> Doubles:
        """How far rounding lets heights be from the true ones, m."""
        normal = np.abs(plane.normal)
        away = normal @ np.abs(bodies.x) + float(normal @ np.abs(plane.point))
        speed = np.linalg.norm(bodies.v, axis=0) if len(bodies.v) else 0.0
        return ROUNDING * np.asarray(away + bodies.reach + speed * self.interval)

    def _noise(self, bodies: Bodies) -> Doubles:
        """Speeds across a plane that rounding gives what moves along it, m/s."""
        return 1e-12 * np.asarray(np.linalg.norm(bodies.v, axis=0)) + self._nothing(bodies)

    def _nothing(self, bodies: Bodies) -> Doubles:
        """Speeds that do not tell a particle from one at rest, m/s."""
        return ROUNDING * bodies.reach / self.interval

    def _refuse_buried(self, bodies: Bodies) -> None:
        for plane in self.planes:
            buried = (height(plane, bodies.x) < -4 * self._margin(plane, bodies)) & (bodies.on != STUCK)
            if buried.any():
                number, time = bodies.ids[buried][0], bodies.times[buried][0]
                raise CannotJudgeError(
                    f"particle {number} is below a plane at t = {time:.6g} s and moves away from it, "
                    "which has no exact meaning"
                )

    def _lay(self, bodies: Bodies) -> Mask:
        """Put first-order bodies that are below planes onto them; true for those that are killed."""
        killed = np.zeros(len(bodies), bool)
        raw = self.free(bodies)
        for k, plane in enumerate(self.planes):
            low = height(plane, bodies.x) <= self._margin(plane, bodies)
            hit = low & (along(plane, raw) < 0) & (bodies.on != k) & (bodies.on != STUCK)
            below = low & (bodies.on != STUCK)
            bodies.x[:, below] -= np.outer(plane.normal, height(plane, bodies.x[:, below]))
            killed |= hit & (plane.on_hit == "die")
            bodies.on[hit & (plane.on_hit == "stick")] = STUCK
        return killed

    def _rests(self, plane: Plane, bodies: Bodies, raw: Doubles) -> Mask:
        """Whether bodies stay on a plane: they touch it, are pressed, and bounce no more."""
        pressing = -along(plane, raw[-3:])
        touches = np.abs(height(plane, bodies.x)) <= self._margin(plane, bodies)
        if len(raw) == 3:
            return touches & (pressing > 0)
        speed = along(plane, bodies.v)
        over = 2 * speed <= pressing * (1 - plane.restitution) * REST * self.interval
        lowly = speed**2 <= 8 * self._margin(plane, bodies) * pressing
        return touches & (pressing > 0) & (speed >= -self._noise(bodies)) & (over | lowly)


def along(plane: Plane, vectors: Doubles) -> Doubles:
    """The components of vectors (3, n) along a plane's normal, shape (n,)."""
    return np.asarray(plane.normal @ vectors)


def height(plane: Plane, x: Doubles) -> Doubles:
    """Heights above a plane, m, shape (n,), of points of shape (3, n)."""
    return along(plane, x) - float(np.dot(plane.normal, plane.point))


def lowered(plane: Plane, bodies: Bodies) -> Bodies:
    """Bodies on a plane, without what rounding has added across it."""
    bodies.x[:] -= np.outer(plane.normal, height(plane, bodies.x))
    bodies.v[:] -= np.outer(plane.normal, along(plane, bodies.v)) if len(bodies.v) else 0.0
    return bodies


def _tangential(plane: Plane, vectors: Doubles) -> Doubles:
    return vectors - np.outer(plane.normal, along(plane, vectors))


def _coulomb(plane: Plane) -> float:
    return plane.friction.coulomb if isinstance(plane.friction, Coulomb) else 0.0


def _unit(vectors: Doubles) -> Doubles:
    lengths = np.linalg.norm(vectors, axis=0)
    return vectors / np.where(lengths > 0, lengths, 1.0)


def _on_plane(plane: Plane, bodies: Bodies, raw: Doubles) -> Doubles:
    """Time derivatives of the states of bodies that rest or slide on a plane, from those of free bodies."""
    pressing = np.maximum(-along(plane, raw[-3:]), 0.0)
    pull = raw[-3:] + np.outer(plane.normal, pressing)
    if len(raw) == 3:
        return pull
    sliding = _tangential(plane, bodies.v)
    if isinstance(plane.friction, Coulomb):
        onward = (sliding * bodies.forward).sum(axis=0) > 0
        pull -= plane.friction.coulomb * pressing * np.where(onward, _unit(sliding), bodies.forward)
    else:
        pull -= plane.friction.viscous * pressing * sliding
    return np.concatenate([raw[:3], pull])


def _hold(plane: Plane, bodies: Bodies, raw: Doubles) -> Doubles:
    """Gaps until bodies leave a plane, and until their sliding stops or their holding fails, shape (2, n)."""
    slack = SLACK * np.linalg.norm(raw[-3:], axis=0)
    pressing = -along(plane, raw[-3:])
    gaps = np.stack([pressing + slack, np.full(len(bodies), np.inf)])
    friction = _coulomb(plane)
    if len(raw) == 6 and friction > 0:
        pull = np.linalg.norm(_tangential(plane, raw[3:]), axis=0)
        onward = (bodies.v * bodies.forward).sum(axis=0)
        gaps[1] = np.where(bodies.held, friction * pressing - pull + slack, onward)
    return gaps


def _rebound(plane: Plane, v: Doubles) -> Doubles:
    """Velocities after an impact."""
    impulse = -(1 + plane.restitution) * along(plane, v)
    turned = v + np.outer(plane.normal, impulse)
    sliding = _tangential(plane, turned)
    speed = np.linalg.norm(sliding, axis=0)
    if isinstance(plane.friction, Coulomb):
        kept = np.maximum(0.0, 1 - plane.friction.coulomb * impulse / np.where(speed > 0, speed, np.inf))
    else:
        kept = np.exp(-plane.friction.viscous * impulse)
    return turned - (1 - kept) * sliding


def _at_rest(plane: Plane, bodies: Bodies, raw: Doubles) -> Bodies:
    """Bodies put to rest on a plane, where they slide on or friction holds them."""
    speed = np.linalg.norm(bodies.v, axis=0) if len(bodies.v) else np.zeros(len(bodies))
    bodies = lowered(plane, bodies)
    if len(raw) == 3:
        return bodies
    sliding = np.linalg.norm(bodies.v, axis=0)
    still = sliding <= 1e-15 * speed
    bodies.v[:, still] = 0.0
    pull = _tangential(plane, raw[3:])
    pressing = -along(plane, raw[3:])
    slack = SLACK * np.linalg.norm(raw[3:], axis=0)
    friction = _coulomb(plane)
    bodies.held = still & (friction > 0) & (np.linalg.norm(pull, axis=0) <= friction * pressing + slack)
    bodies.forward = np.where(still, _unit(pull), _unit(bodies.v))
    return bodies

"""Planes in pilots: impacts within a step of the sample, located as the engine locates them, but more roughly."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from particlecli.auto.steps import Doubles, Sampled, Step
from particlecli.scene.planes import Coulomb, Plane

MOST_IMPACTS = 4
"""Impacts within a step that are followed; what is still below then comes to rest on the plane."""

CORRECTIONS = 2
"""Newton steps towards the instant of an impact."""


class Grounds:
    """The planes that a group meets.

    Args:
        planes: the planes.
        located: whether impacts happen within the step, or at its end.
        newtonian: whether the particles have velocities.
        count: how many particles there are.

    Attributes:
        held: which particles a plane holds or has killed, shape (n,).
    """

    def __init__(self, planes: Sequence[Plane], *, located: bool, newtonian: bool, count: int) -> None:
        self._planes, self._located, self._newtonian = planes, located and newtonian, newtonian
        self.held = np.zeros(count, bool)

    def step(self, step: Step, sample: Sampled, h: Doubles, here: NDArray[np.int64]) -> Doubles:
        """The states after a step of lengths `h`, s, of some particles, those at the places `here`."""
        new = step(sample, h)
        if not self._planes:
            return new
        held = self.held[here]
        new[:, held] = sample.states[:, held]
        if self._located:
            self._locate(step, sample, h, new, held)
        for plane in self._planes:
            below = self._below(plane, new) & ~held
            if below.any():
                new[:, below] = self._struck(plane, new[:, below], below, held, rests=self._located)
        self.held[here] = held
        return new

    def _locate(self, step: Step, sample: Sampled, h: Doubles, new: Doubles, held: NDArray[np.bool_]) -> None:
        states, times, left = sample.states.copy(), sample.times.copy(), h.copy()
        for _ in range(MOST_IMPACTS):
            first, plane = self._first(new, held)
            if not len(first):
                break
            part = Sampled(states[:, first], times[first], sample.weights[first])
            when = left[first] * self._share(part.states, new[:, first], plane[first])
            for _ in range(CORRECTIONS):
                height, speed = self._height(step(part, when), plane[first])
                when = np.clip(when - height / np.where(speed < 0, speed, -1.0), 0.0, left[first])
            there = step(part, when)
            for k, each in enumerate(self._planes):
                hit = plane[first] == k
                there[:, hit] = self._struck(each, there[:, hit], first[hit], held, rests=False)
            states[:, first], times[first], left[first] = there, times[first] + when, left[first] - when
            rest = Sampled(there, times[first], part.weights)
            new[:, first] = np.where(held[first], there, step(rest, left[first]))

    def _first(self, new: Doubles, held: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Which particles end below a plane, heading in, and below which one the deepest, for all, shape (n,)."""
        depths = np.stack([np.where(self._below(p, new), -self._of(p, new)[0], 0.0) for p in self._planes])
        depths[:, held] = 0.0
        return np.flatnonzero(depths.max(axis=0) > 0.0), np.argmax(depths, axis=0)

    def _share(self, old: Doubles, new: Doubles, plane: NDArray[np.int64]) -> Doubles:
        """The part of the step before the impact, by the heights at both ends."""
        before, after = self._height(old, plane)[0], self._height(new, plane)[0]
        return np.asarray(np.clip(before / np.maximum(before - after, 1e-300), 0.0, 1.0))

    def _height(self, states: Doubles, plane: NDArray[np.int64]) -> tuple[Doubles, Doubles]:
        both = [self._of(each, states) for each in self._planes]
        columns = np.arange(states.shape[1])
        return np.stack([one[0] for one in both])[plane, columns], np.stack([one[1] for one in both])[plane, columns]

    def _of(self, plane: Plane, states: Doubles) -> tuple[Doubles, Doubles]:
        """Height above a plane and its rate of change."""
        normal = np.array(plane.normal)
        height = normal @ states[:3] - float(normal @ np.array(plane.point))
        return height, normal @ states[3:] if self._newtonian else np.full_like(height, -1.0)

    def _below(self, plane: Plane, states: Doubles) -> NDArray[np.bool_]:
        height, speed = self._of(plane, states)
        return np.asarray((height < 0.0) & (speed < 0.0))

    def _struck(
        self, plane: Plane, states: Doubles, places: NDArray[Any], held: NDArray[np.bool_], *, rests: bool
    ) -> Doubles:
        """States put onto a plane, turned round or held."""
        normal = np.array(plane.normal)[:, None]
        height, speed = self._of(plane, states)
        after = states.copy()
        after[:3] -= normal * height
        if plane.on_hit != "bounce":
            held[places] = True
            after[3:] = 0.0
            return after
        if self._newtonian:
            impulse = np.maximum(0.0, -(1.0 + (0.0 if rests else plane.restitution)) * speed)
            turned = after[3:] + normal * impulse
            sliding = turned - normal * (normal * turned).sum(axis=0)
            after[3:] = turned - (1.0 - _kept(plane, impulse, sliding)) * sliding
        return after


def _kept(plane: Plane, impulse: Doubles, sliding: Doubles) -> Doubles:
    """The share of the sliding velocity that friction leaves."""
    if isinstance(plane.friction, Coulomb):
        return np.asarray(
            np.maximum(0.0, 1.0 - plane.friction.coulomb * impulse / (np.linalg.norm(sliding, axis=0) + 1e-300))
        )
    return np.asarray(np.exp(-plane.friction.viscous * impulse))

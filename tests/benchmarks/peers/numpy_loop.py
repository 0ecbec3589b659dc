"""NumPy: whole arrays, operation by operation, in single precision."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tests.benchmarks.contest import State
from tests.benchmarks.dust import STEPS, Dust

Indices = NDArray[np.intp]


class NumPy:
    """Particles in an array of rows."""

    def __init__(self, dust: Dust, start: State) -> None:
        self.dust = dust
        self._start = start
        self._state = start.copy()

    def restart(self) -> None:
        """Put all particles back to where they began."""
        self._state[:] = self._start

    def advance(self) -> None:
        """Advance all particles by a frame."""
        for _ in range(STEPS):
            self.step()

    def state(self) -> State:
        """Where the particles are now."""
        return self._state

    def step(self) -> Indices:
        """Advance all particles by a step; the indices of those that meet the plane in it."""
        x, v = self._state[:3], self._state[3:]
        before, fall = x.copy() if self.dust.friction else x, v[1].copy()
        if self.dust.scheme == "rk4":
            self._rk4(x, v)
        else:
            v += np.float32(self.dust.dt) * self._acceleration(x, v)
            x += np.float32(self.dust.dt) * v
        return self._meet_plane(x, v, before, v[1] - fall)

    def _rk4(self, x: State, v: State) -> None:
        h = self.dust.dt
        stage_x, stage_v = x, v
        sum_v, sum_a = np.zeros_like(x), np.zeros_like(v)
        for ahead, weight in ((h / 2, h / 6), (h / 2, h / 3), (h, h / 3), (0.0, h / 6)):
            a = self._acceleration(stage_x, stage_v)
            sum_v += np.float32(weight) * stage_v
            sum_a += np.float32(weight) * a
            stage_x, stage_v = x + np.float32(ahead) * stage_v, v + np.float32(ahead) * a
        x += sum_v
        v += sum_a

    def _acceleration(self, x: State, v: State) -> State:
        dust = self.dust
        a: State = np.float32(-dust.drag) * v
        a[1] -= np.float32(dust.gravity)
        if dust.forces == 4:
            a -= np.float32(dust.quadratic_drag) * np.sqrt(np.einsum("ij,ij->j", v, v)) * v
            d = x - np.array([[0.0], [dust.mass_height], [0.0]], np.float32)
            r2 = np.einsum("ij,ij->j", d, d) + np.float32(dust.softening**2)
            a -= np.float32(dust.mass_strength) / (r2 * np.sqrt(r2)) * d
        return a

    def _meet_plane(self, x: State, v: State, before: State, gained: State) -> Indices:
        """The plane is met by few: only those are worked on."""
        hit = np.flatnonzero((x[1] < 0) & (v[1] < 0))
        fall, e = v[1, hit], np.float32(self.dust.restitution)
        rebound = -e * fall
        rests = rebound <= -2 * gained[hit]
        v[1, hit] = np.where(rests, 0, rebound)
        x[1, hit] = np.where(rests, 0, -e * x[1, hit])
        if self.dust.friction:
            slide = np.hypot(v[0, hit], v[2, hit]) + np.float32(1e-30)
            kept = np.maximum(0, 1 - np.float32(self.dust.friction) * (v[1, hit] - fall) / slide)
            stays = rests & (kept <= 0)
            for c in (0, 2):
                v[c, hit] *= kept
                x[c, hit] = np.where(stays, before[c, hit], x[c, hit])
        return hit


def share_that_meets_plane(dust: Dust, start: State) -> float:
    """The share of the particles that meet the plane in a frame, the mean over all frames."""
    particles = NumPy(dust, start)
    met = np.zeros((dust.frames, start.shape[1]), bool)
    for frame in met:
        for _ in range(STEPS):
            frame[particles.step()] = True
    return float(met.mean())

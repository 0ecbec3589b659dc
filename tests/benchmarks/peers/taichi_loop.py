"""Taichi as it is usually written: arrays of vectors, one particle a turn of the loop."""

import numpy as np
import taichi as ti

from tests.benchmarks.contest import State
from tests.benchmarks.dust import STEPS, Dust


class TaichiLoop:
    """Particles in two fields of vectors; `Simulation` has started Taichi."""

    def __init__(self, dust: Dust, start: State) -> None:
        self._start = start
        self._numbers = (dust.dt, dust.gravity, dust.drag, dust.restitution)
        self._x = ti.Vector.field(3, ti.f32, shape=dust.count)
        self._v = ti.Vector.field(3, ti.f32, shape=dust.count)
        _frame(self._x, self._v, 0, *self._numbers)

    def restart(self) -> None:
        """Put all particles back to where they began."""
        self._x.from_numpy(self._start[:3].T.copy())
        self._v.from_numpy(self._start[3:].T.copy())

    def advance(self) -> None:
        """Advance all particles by a frame."""
        _frame(self._x, self._v, STEPS, *self._numbers)

    def state(self) -> State:
        """Where the particles are now."""
        return np.concatenate([self._x.to_numpy().T, self._v.to_numpy().T])


@ti.kernel
def _frame(
    x: ti.template(),
    v: ti.template(),
    steps: ti.i32,
    dt: ti.f32,
    gravity: ti.f32,
    drag: ti.f32,
    restitution: ti.f32,
):
    for i in x:
        xi, vi = x[i], v[i]
        for _ in range(steps):
            gained = dt * (-gravity - drag * vi[1])
            vi += dt * (ti.Vector([0.0, -gravity, 0.0]) - drag * vi)
            xi += dt * vi
            if xi[1] < 0 and vi[1] < 0:
                rebound = -restitution * vi[1]
                rests = rebound <= -2 * gained
                vi[1] = 0.0 if rests else rebound
                xi[1] = 0.0 if rests else -restitution * xi[1]
        x[i], v[i] = xi, vi

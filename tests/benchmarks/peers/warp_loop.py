"""NVIDIA Warp on the CPU: arrays of vectors, one particle a thread."""

import numpy as np
import warp as wp

from tests.benchmarks.contest import State
from tests.benchmarks.dust import STEPS, Dust

wp.config.log_level = wp.LOG_ERROR


class Warp:
    """Particles in two arrays of vectors."""

    def __init__(self, dust: Dust, start: State) -> None:
        self._start = start
        self._count = dust.count
        self._numbers = [dust.dt, dust.gravity, dust.drag, dust.restitution]
        self.restart()
        self._launch(0)

    def restart(self) -> None:
        """Put all particles back to where they began."""
        self._x = wp.array(self._start[:3].T.copy(), dtype=wp.vec3, device="cpu")
        self._v = wp.array(self._start[3:].T.copy(), dtype=wp.vec3, device="cpu")

    def advance(self) -> None:
        """Advance all particles by a frame."""
        self._launch(STEPS)

    def state(self) -> State:
        """Where the particles are now."""
        return np.concatenate([self._x.numpy().T, self._v.numpy().T])

    def _launch(self, steps: int) -> None:
        wp.launch(_frame, dim=self._count, inputs=[self._x, self._v, steps, *self._numbers], device="cpu")


@wp.kernel
def _frame(
    x: wp.array(dtype=wp.vec3),
    v: wp.array(dtype=wp.vec3),
    steps: int,
    dt: float,
    gravity: float,
    drag: float,
    restitution: float,
):
    i = wp.tid()
    xi = x[i]
    vi = v[i]
    for _s in range(steps):
        gained = dt * (-gravity - drag * vi[1])
        vi = vi + dt * (wp.vec3(0.0, -gravity, 0.0) - drag * vi)
        xi = xi + dt * vi
        if xi[1] < 0.0 and vi[1] < 0.0:
            rebound = -restitution * vi[1]
            if rebound <= -2.0 * gained:
                vi = wp.vec3(vi[0], 0.0, vi[2])
                xi = wp.vec3(xi[0], 0.0, xi[2])
            else:
                vi = wp.vec3(vi[0], rebound, vi[2])
                xi = wp.vec3(xi[0], -restitution * xi[1], xi[2])
    x[i] = xi
    v[i] = vi

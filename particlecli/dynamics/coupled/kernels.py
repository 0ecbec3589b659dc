"""The stages of coupled particles, one launch each, shared out among threads."""

import taichi as ti

from particlecli.dynamics.coupled.sharing import SHARE
from particlecli.dynamics.coupled.step import Step
from particlecli.dynamics.group_plan import LANES


@ti.data_oriented
class StageKernels:
    """Kernels over all packs.

    Args:
        step: what a pack does.
    """

    def __init__(self, step: Step) -> None:
        self.step = step
        self.points = step.points
        self.ending = step.ending
        self.real = step.real
        self.errors = ti.field(step.real, shape=self.points.capacity)

    @ti.kernel
    def load(self, packs: ti.i32):
        """Take the points from the state of their groups."""
        for b in range(packs):
            self.ending.load(b)

    @ti.kernel
    def store(self, packs: ti.i32, interval: ti.f64, flags: ti.types.ndarray(dtype=ti.i32, ndim=2)):
        """Put points back into the state of their groups after an interval, s; a row of flags for each group."""
        for b in range(packs):
            self.ending.check(b, flags)
        for b in range(packs):
            self.ending.store(b, ti.cast(interval, self.real), flags)

    @ti.kernel
    def stage(
        self,
        i: ti.i32,
        beginning: ti.i32,
        evaluating: ti.i32,
        following: ti.i32,
        ending: ti.i32,
        start: ti.f64,
        now: ti.f64,
        length: ti.f64,
    ):
        """Evaluation i of a step from `now`, s after `start`, and what goes with it; each for so many packs."""
        for b in range(beginning):
            self.step.begin(b, ti.cast(start, self.real), ti.cast(now, self.real), ti.cast(length, self.real))
        ti.loop_config(block_dim=SHARE)
        for b in range(evaluating):
            t = ti.cast(start + now, self.real) + self.step.times[i] * ti.cast(length, self.real)
            self.step.evaluate(i, b, t)
        for b in range(following):
            self.step.follow(i, b, ti.cast(start + now, self.real), ti.cast(length, self.real))
        for b in range(ending):
            t0, h = ti.cast(start, self.real), ti.cast(length, self.real)
            self.ending.finish(b, t0, ti.cast(now, self.real), h)
        for b in range(ending):
            self.step.motion.end_step(b, ti.cast(start + now + length, self.real))

    @ti.kernel
    def end(self, packs: ti.i32, start: ti.f64, now: ti.f64, length: ti.f64):
        """The end of a step that was accepted."""
        for b in range(packs):
            t0, h = ti.cast(start, self.real), ti.cast(length, self.real)
            self.ending.finish(b, t0, ti.cast(now, self.real), h)
        for b in range(packs):
            self.step.motion.end_step(b, ti.cast(start + now + length, self.real))

    @ti.kernel
    def revert(self, packs: ti.i32):
        """Back to the beginning of a step that was not."""
        for b in range(packs):
            self.step.revert(b)

    @ti.kernel
    def error(self, packs: ti.i32, tolerance: ti.f64) -> ti.f64:
        """The largest error of any particle, 1 being tolerated."""
        for b in range(packs):
            self.errors[b] = self.step.error(b, ti.cast(tolerance, self.real))
        largest = ti.cast(0.0, self.real)
        ti.loop_config(serialize=True)
        for b in range(packs):
            largest = ti.max(largest, self.errors[b])
        return largest

    @ti.kernel
    def differentiate(self, packs: ti.i32, time: ti.f64, out: ti.types.ndarray(dtype=ti.f64, ndim=2)):
        """Velocities and accelerations, six rows; zero where a particle does not move."""
        for b in range(packs):
            t = ti.cast(time, self.real)
            a = self.step.motion.acceleration(b, t)
            led = self.ending.pins.slopes(b, t)
            self.ending.begin(b, ti.cast(0.0, self.real), ti.cast(1.0, self.real))
            moves = self.ending.reaches[b] > 0.0
            for c in ti.static(range(3)):
                velocity = ti.select(moves, self.points.state[c + 3, b], led[c])
                slope = ti.select(moves, a[c], led[c + 3])
                for lane in ti.static(range(LANES)):
                    out[c, b * LANES + lane] = velocity[lane]
                    out[c + 3, b * LANES + lane] = slope[lane]

    @ti.kernel
    def potential(self, j: ti.template(), packs: ti.i32, time: ti.f64, out: ti.types.ndarray(dtype=ti.f64, ndim=2)):
        """The potential energy of force j that each particle shares in, J; a row for each pack."""
        for b in range(packs):
            energy = self.step.motion.potential(j, b, ti.cast(time, self.real))
            for lane in ti.static(range(LANES)):
                out[b, lane] = energy[lane]

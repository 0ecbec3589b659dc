"""All steps of a frame of a few coupled particles in one kernel, on one thread."""

import taichi as ti

from particlecli.dynamics.coupled.step import Step
from particlecli.dynamics.integrators.adaptive import AdaptiveStepper
from particlecli.dynamics.paced import FIRST_STEP, SHORTEST_STEP


@ti.data_oriented
class SerialMarch:
    """Steps of equal length, or at the pace of the estimated error.

    Args:
        step: what a pack does.
        stepper: that knows how to change the step, if the scheme is adaptive.
    """

    def __init__(self, step: Step, stepper: AdaptiveStepper | None = None) -> None:
        self.step = step
        self.ending = step.ending
        self.stepper = stepper
        self.real = step.real

    @ti.kernel
    def evenly(
        self,
        packs: ti.i32,
        start: ti.f64,
        interval: ti.f64,
        steps: ti.i32,
        flags: ti.types.ndarray(dtype=ti.i32, ndim=2),
    ):
        """So many equal steps through an interval, s, from a time, s; `flags` as of `StageKernels.check`."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            self._load(packs)
            h, t0 = ti.cast(interval / steps, self.real), ti.cast(start, self.real)
            for s in range(steps):
                self._move(packs, t0, s * h, h, s > 0)
                self._finish(packs, t0, s * h, h)
            self._store(packs, interval, flags)

    @ti.kernel
    def paced(
        self,
        packs: ti.i32,
        start: ti.f64,
        interval: ti.f64,
        longest: ti.f64,
        tolerance: ti.f64,
        flags: ti.types.ndarray(dtype=ti.i32, ndim=2),
        record: ti.types.ndarray(dtype=ti.f64, ndim=1),
    ):
        """Steps by the estimated error; `record`: see `CoupledSystem`."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            self._load(packs)
            span, t0 = ti.cast(interval, self.real), ti.cast(start, self.real)
            liked, last = ti.cast(record[0], self.real), ti.cast(record[1], self.real)
            liked = ti.select(liked > 0.0, liked, FIRST_STEP * span)
            now = 0.0 * span
            taken, tried = 0, 0
            while (now < span) & (liked >= SHORTEST_STEP * span):
                h = ti.min(ti.min(liked, ti.cast(longest, self.real)), span - now)
                h = ti.select(span - now - h < 1e-9 * span, span - now, h)
                self._move(packs, t0, now, h, False)
                error = self._error(packs, ti.cast(tolerance, self.real))
                tried += 1
                if error <= 1.0:
                    self._finish(packs, t0, now, h)
                    factor = self.stepper.change(error, last)
                    liked = ti.max(liked, h * factor) if h < liked else h * factor
                    last = ti.max(error, 1e-4)
                    now = ti.select(h < span - now, now + h, span)
                    taken += 1
                else:
                    for b in range(packs):
                        self.step.revert(b)
                    liked = h * ti.min(self.stepper.change(error, 1.0), 0.9)
            record[0], record[1], record[2], record[3] = liked, last, taken, tried
            record[4] = ti.select(now < span, ti.cast(now, ti.f64), interval)
            self._store(packs, interval, flags)

    @ti.func
    def _load(self, packs):
        for b in range(packs):
            self.ending.load(b)

    @ti.func
    def _store(self, packs, interval, flags: ti.template()):
        for b in range(packs):
            self.ending.check(b, flags)
        for b in range(packs):
            self.ending.store(b, ti.cast(interval, self.real), flags)

    @ti.func
    def _move(self, packs, t0, now, h, again):
        """The motion in a step; `again`: it follows another one, whose last accelerations may serve again."""
        for b in range(packs):
            self.step.begin(b, t0, now, h)
        for i in range(self.step.evaluations):
            if not (self.step.reuses & again & (i == 0)):
                for b in range(packs):
                    self.step.evaluate(i, b, t0 + now + self.step.times[i] * h)
            for b in range(packs):
                self.step.follow(i, b, t0 + now, h)

    @ti.func
    def _finish(self, packs, t0, now, h):
        for b in range(packs):
            self.ending.finish(b, t0, now, h)
        for b in range(packs):
            self.step.motion.end_step(b, t0 + now + h)

    @ti.func
    def _error(self, packs, tolerance):
        largest = ti.cast(0.0, self.real)
        for b in range(packs):
            largest = ti.max(largest, self.step.error(b, tolerance))
        return largest

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
        self.adapts = stepper is not None
        self.real = step.real

    @ti.kernel
    def evenly(
        self,
        packs: ti.i32,
        start: ti.f64,
        interval: ti.f64,
        steps: ti.i32,
        flags: ti.types.ndarray(dtype=ti.i32, ndim=2),
        record: ti.types.ndarray(dtype=ti.f64, ndim=1),
    ):
        """So many equal steps through an interval, s, from a time, s.

        `flags` as of `StageKernels.check`; `record`: see `CoupledSystem`, here only how many steps were tried.
        """
        ti.loop_config(serialize=True)
        for _ in range(1):
            self._load(packs)
            h, t0 = ti.cast(interval / steps, self.real), ti.cast(start, self.real)
            tried, crowd = 0, 0
            for s in range(steps):
                done = 0.0 * h
                while done < h:
                    left, now = h - done, s * h + done
                    taken, _error, tries = self._stride(
                        packs, t0, now, left, h, (s > 0) & (done == 0.0), 0.0 * h, crowd
                    )
                    self._finish(packs, t0, now, taken)
                    crowd = ti.select(taken < left, crowd + tries, 0)
                    done = ti.select(taken < left, done + taken, h)
                    tried += tries
            record[3] = tried
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
            steps, tried, crowd = 0, 0, 0
            while (now < span) & (liked >= SHORTEST_STEP * span):
                h = ti.min(ti.min(liked, ti.cast(longest, self.real)), span - now)
                h = ti.select(span - now - h < 1e-9 * span, span - now, h)
                bound = ti.cast(tolerance, self.real)
                taken, error, tries = self._stride(packs, t0, now, h, h, False, bound, crowd)
                tried += tries
                if error <= 1.0:
                    self._finish(packs, t0, now, taken)
                    factor = self.stepper.change(error, last)
                    liked = ti.max(liked, h * factor) if h < liked else h * factor
                    last = ti.max(error, 1e-4)
                    crowd = ti.select(taken < h, crowd + tries, 0)
                    now = ti.select((taken < h) | (h < span - now), now + taken, span)
                    steps += 1
                else:
                    for b in range(packs):
                        self.step.revert(b)
                    liked = h * ti.min(self.stepper.change(error, 1.0), 0.9)
            record[0], record[1], record[2], record[3] = liked, last, steps, tried
            record[4] = ti.select(now < span, ti.cast(now, ti.f64), interval)
            self._store(packs, interval, flags)

    @ti.func
    def _load(self, packs):
        for b in range(packs):
            self.ending.load(b)
            if ti.static(self.step.locates):
                self.step.impacts.calm(b)

    @ti.func
    def _store(self, packs, interval, flags: ti.template()):
        for b in range(packs):
            self.ending.check(b, flags)
        for b in range(packs):
            self.ending.store(b, ti.cast(interval, self.real), flags)

    @ti.func
    def _stride(self, packs, t0, now, h, whole, again, tolerance, crowd):
        """A step, or its part up to the first event within it.

        Args:
            h: how long it may be, s.
            whole: length of the step that it is a part of, s.
            again: whether it follows a step, whose last accelerations may serve again.
            tolerance: of the error, of adaptive schemes.
            crowd: trials since the last step in which nothing happened.

        Returns:
            How far it went, the estimated error of adaptive schemes, and how many trials it took.
        """
        self._move(packs, t0, now, h, again)
        error = 0.0 * h
        if ti.static(self.adapts):
            error = self._error(packs, tolerance)
        return h, error, 1

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

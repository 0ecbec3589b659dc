"""The steps of a frame for single particles that each choose their own step by the estimated error."""

import taichi as ti

from particlecli.dynamics.deaths import Fate
from particlecli.dynamics.march import March

FIRST_STEP = 1e-2
"""The first step that is tried, as a part of the frame interval."""

SHORTEST_STEP = 1e-12
"""A step shorter than so many frame intervals means that the error cannot be controlled."""


@ti.data_oriented
class PacedMarch:
    """Takes single particles through a frame at their own pace, from birth, impact or frame to the next.

    Args:
        march: what else happens in a step: contact, cooling, causes of death.
    """

    def __init__(self, march: March) -> None:
        self.march = march
        self.stepper = march.stepper

    @ti.func
    def advance(self, p, t0, interval, longest, tolerance, pace, state, own, fate, temperature):
        """The particle after an interval.

        Args:
            p: parameter lists.
            t0: time at the beginning, s.
            interval: s.
            longest: longest step allowed, s.
            tolerance: error tolerated in a step, see `AdaptiveStepper.attempt`.
            pace: step the particle would like, s; 0: not known yet.
            state, own, fate, temperature: as of `March.advance`, scalars.

        Returns:
            x, y, z, u, v, w, fate, temperature, pace, steps taken, steps tried, age reached. The state is NaN where the
            error could not be controlled.
        """
        x, y, z, u, v, w = state[0], state[1], state[2], state[3], state[4], state[5]
        end, warmth = fate, temperature
        now = ti.max(-own[0], 0.0)
        until = self._until(own, interval)
        liked = ti.select(pace > 0.0, pace, FIRST_STEP * interval)
        last, taken, tried = 1e-4 + 0.0 * x, 0, 0
        while (now < until) & (end <= 0):
            h = ti.min(ti.min(liked, longest), until - now)
            h = ti.select(until - now - h < 1e-9 * interval, until - now, h)
            if end != int(Fate.ALIVE):
                h = until - now
            here = [x, y, z, u, v, w]
            nx, ny, nz, nu, nv, nw, error = self.stepper.attempt(p, here, t0 + now, h, [own[3]], tolerance)
            tried += 1
            if (error <= 1.0) | (end != int(Fate.ALIVE)):
                if end == int(Fate.ALIVE):
                    x, y, z, u, v, w, end = self.march.met(
                        p, here, [nx, ny, nz, nu, nv, nw], t0 + now, h, own, end, True
                    )
                    factor = self.stepper.change(error, last)
                    liked = ti.max(liked, h * factor) if h < liked else h * factor
                    last = ti.max(error, 1e-4)
                now = ti.select(h < until - now, now + h, until)
                taken += 1
                warmth = self.march.cooled(p, warmth, own[2], h)
                age = ti.select(until < interval, ti.select(now < until, own[0] + now, own[1]), own[0] + now)
                end = self.march.judged(p[-1], end, [x, y, z], age, own[1], warmth, h)
            else:
                liked = h * ti.select(error > 1.0, ti.min(self.stepper.change(error, 1.0), 0.9), 0.1)
                if liked < SHORTEST_STEP * interval:
                    x = ti.math.nan
                    now = until
        return [x, y, z, u, v, w, end, warmth, liked, taken, tried, own[0] + now]

    @ti.func
    def _until(self, own, interval):
        """How long a particle goes on: to the end of the interval; where a death bears children, of its lifetime."""
        until = interval
        if ti.static(self.march.bears_at_death and self.march.plan.mortal):
            until = ti.min(until, own[1] - own[0])
        return until

"""Flights of a few particles through a whole scene in one launch, with any explicit scheme at any pace.

Tableau, pace and planes are data, and the equations of motion appear once, so that one small kernel flies all schemes:
each turn of its loop is a step that is tried from the present state, and what it brought decides what comes next.
Impacts within a step are located as the engine locates them, but more roughly.
"""

from typing import NamedTuple

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli.dynamics.flight_planes import FlightPlanes, Search
from particlecli.dynamics.flight_schemes import (
    ADAPTIVELY,
    COARSE,
    DRIFT,
    ERROR,
    EVENLY,
    SPLIT,
    TIME,
    WEIGHT,
    Explicit,
    scheme_table,
)
from particlecli.dynamics.integrators.base import Splitting
from particlecli.dynamics.motion import Motion
from particlecli.dynamics.probe import IDLE, Column, Counts, Doubles, Probe, Table, Tables
from particlecli.runtime import Precision

SHORTEST = 1e-6
"""A step shorter than so many frames means that the error cannot be controlled."""

FIRST, SAFETY, SHRINKS, GROWS = 0.01, 0.9, 0.2, 8.0
"""The first step of an adaptive scheme in frames, and how its steps change, as the engine has them."""


class Course(NamedTuple):
    """What particles fly through.

    Attributes:
        interval: from one frame to the next, s.
        frames: how many each particle lives, shape (n,).
        planes: a row for each, see `flight_planes`, shape (planes, 8).
        located: whether impacts happen within the step, or at its end.
        box: corners of the box outside of which particles die, shape (2, 3).
    """

    interval: float
    frames: NDArray[np.int32]
    planes: Doubles
    located: bool
    box: Doubles


@ti.data_oriented
class Flights(Probe):
    """A probe that also flies particles, each from an instant of its own.

    Args:
        motion: the equations of motion, the tables of its flows filled in.
        precision: of the forces, the one the runtime was started with; states are double.
        most: particles that fly together, at most.
    """

    def __init__(self, motion: Motion, precision: Precision, most: int) -> None:
        super().__init__(motion, precision)
        self.planes = FlightPlanes(self.components)
        self.slopes = ti.field(ti.f64, shape=(max(1, most), 16, IDLE))

    def fly(
        self,
        scheme: Explicit,
        states: Doubles,
        times: Doubles,
        inverse_masses: Doubles,
        course: Course,
        steps: int,
        tolerance: float | None,
    ) -> tuple[Doubles, Doubles]:
        """Fly with so many equal steps in a frame, or with an error tolerated in a step.

        Args:
            scheme: an adaptive one takes equal steps where there is no tolerance.
            states, times, inverse_masses: as of `derivative`.
            course: what they fly through.
            steps: in a frame.
            tolerance: m and m/s, relative to coordinates and speeds above 1.

        Returns:
            Positions at each frame after the start, shape (frames, n, 3), m, NaN where a particle lives no more or its
            flight has failed; and the steps tried, shape (n,).
        """
        kind = SPLIT if isinstance(scheme, Splitting) else EVENLY if tolerance is None else ADAPTIVELY
        weights, rows, last, exponent = scheme_table(scheme)
        count = states.shape[1]
        out = np.full((int(course.frames.max(initial=0)), count, 3), np.nan)
        tried = np.zeros(count)
        if out.size:
            full = np.zeros((IDLE, count))
            full[: len(states)] = states
            planes = course.planes if len(course.planes) else np.zeros((1, 8))
            self._fly(
                full, times, inverse_masses, course.frames, course.interval, weights, rows, last, exponent, kind,
                steps, tolerance or 1.0, planes, len(course.planes), int(course.located), course.box, out, tried,
            )  # fmt: skip
        return out, tried

    @ti.kernel
    def _fly(
        self, states: Table, times: Column, inverse_masses: Column, frames: Counts, interval: ti.f64, weights: Table,
        rows: Table, last: ti.f64, exponent: ti.f64, kind: ti.i32, steps: ti.i32, tolerance: ti.f64, planes: Table,
        plane_count: ti.i32, located: ti.i32, box: Table, out: Tables, tried: Column,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for i in range(states.shape[1]):
            p = self._loaded()
            inverse_mass = ti.cast(inverse_masses[i], self.real)
            y = ti.Vector([states[c, i] for c in range(IDLE)])
            time, pace = times[i], FIRST * interval
            frame, left, part = 0, interval, interval / steps
            search, held = Search(), False
            tries, lives = 0.0, frames[i] > 0
            while lives:
                seeking = search.trial > 0
                h = part if kind != ADAPTIVELY else ti.min(pace, left)
                if seeking:
                    h = search.when
                new = self._stepped(p, i, kind, weights, rows, last, y, time, h, inverse_mass)
                moved, accepted = 0.0 * h, True
                if (kind == ADAPTIVELY) & (not seeking):
                    tries += 1.0
                    error = self._error(i, rows, y, new, h) / tolerance
                    accepted = error <= 1.0
                    pace = self._pace(error, exponent, pace, h)
                    lives = accepted | (pace >= SHORTEST * interval)
                if accepted:
                    y, moved, held = self.planes.passed(planes, plane_count, located, search, y, new, h, held)
                time += moved
                left -= moved
                part -= moved
                if part <= 1e-9 * interval / steps:
                    part = interval / steps
                lives = lives & self._finite(y)
                while lives & ((left <= 1e-9 * interval) | held):
                    for c in ti.static(range(3)):
                        out[frame, i, c] = y[c]
                    frame += 1
                    left, part = interval, interval / steps
                    lives = (frame < frames[i]) & self._within(box, y)
            tried[i] = tries

    @ti.func
    def _stepped(
        self, p, i, kind, weights: ti.template(), rows: ti.template(), last, y, time, h, inverse_mass: ti.template()
    ):
        """The state of flight i after a step of length h."""
        new, drifted = y, 0.0 * h
        for s in range(rows.shape[0]):
            at, then = y, time + rows[s, TIME] * h
            if kind == SPLIT:
                for c in ti.static(range(3)):
                    new[c] = new[c] + rows[s, DRIFT] * h * new[c + 3]
                drifted += rows[s, DRIFT]
                at, then = new, time + drifted * h
            else:
                for j in range(s):
                    for c in ti.static(range(self.components)):
                        at[c] = at[c] + h * weights[s, j] * self.slopes[i, j, c]
            state = [ti.cast(at[c], self.real) for c in ti.static(range(IDLE))]
            k = self.motion.derivative(p, state, ti.cast(then, self.real), [inverse_mass])
            for c in ti.static(range(self.components)):
                slope = ti.cast(k[c], ti.f64)
                self.slopes[i, s, c] = slope
                if (kind != SPLIT) | (c > 2):
                    new[c] = new[c] + h * rows[s, WEIGHT] * slope
        if kind == SPLIT:
            for c in ti.static(range(3)):
                new[c] = new[c] + last * h * new[c + 3]
        return new

    @ti.func
    def _pace(self, error, exponent, pace, h):
        """The step to take after one of length h with this error, 1 being tolerated."""
        bound = error if error < 1e10 else 1e10
        change = ti.min(ti.max(SAFETY * ti.max(bound, 1e-10) ** -exponent, SHRINKS), GROWS)
        larger = ti.max(pace, h * change) if h < pace else h * change
        return larger if bound <= 1.0 else h * ti.min(change, SAFETY)

    @ti.func
    def _error(self, i, rows: ti.template(), y, new, h):
        """The root mean square over the components of the error of a step, relative to coordinates above 1."""
        fine, coarse = 0.0 * h, 0.0 * h
        for c in ti.static(range(self.components)):
            scale = ti.max(1.0, ti.max(abs(y[c]), abs(new[c])))
            first, second = 0.0 * h, 0.0 * h
            for s in range(rows.shape[0]):
                first += rows[s, ERROR] * self.slopes[i, s, c]
                second += rows[s, COARSE] * self.slopes[i, s, c]
            fine += (h * first / scale) ** 2
            coarse += (h * second / scale) ** 2
        fine, coarse = ti.sqrt(fine / 6.0), ti.sqrt(coarse / 6.0)
        if coarse > 0.0:
            fine = fine * fine / (ti.sqrt(fine * fine + 0.01 * coarse * coarse) + 1e-300)
        return fine

    @ti.func
    def _finite(self, y):
        finite = True
        for c in ti.static(range(IDLE)):
            finite = finite & (abs(y[c]) < 1e300)
        return finite

    @ti.func
    def _within(self, box: ti.template(), y):
        inside = True
        for c in ti.static(range(3)):
            inside = inside & (y[c] >= box[0, c]) & (y[c] <= box[1, c])
        return inside

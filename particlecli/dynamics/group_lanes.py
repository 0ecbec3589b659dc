"""The particles of a group one by one: those that meet planes, and those that choose their own steps."""

import taichi as ti

from particlecli.dynamics.algebra import finite
from particlecli.dynamics.deaths import Fate
from particlecli.dynamics.group_plan import INTEGER_COMPONENTS, LANES, Constant
from particlecli.dynamics.march import Way
from particlecli.dynamics.outcome import DIED, FAILED, RESTING
from particlecli.dynamics.paced import PacedMarch


@ti.data_oriented
class GroupLanes:
    """Kernels that take single lanes of a group's packs through a frame.

    Args:
        group: the group.
    """

    def __init__(self, group) -> None:
        self.group = group
        self.paced = PacedMarch(group.march)

    @ti.func
    def _component(self, name: ti.template(), b, lane, constant):
        """The same for a single lane."""
        if ti.static(self.group.has(name)):
            if ti.static(name in INTEGER_COMPONENTS):
                return self.group.state.integers[self.group.state.row(name), b][lane]
            else:
                return self.group.state.reals[self.group.state.row(name), b][lane]
        return constant

    @ti.kernel
    def advance_carefully(
        self,
        packs: ti.i32,
        count: ti.i32,
        start: ti.f64,
        interval: ti.f64,
        steps: ti.i32,
        flags: ti.types.ndarray(dtype=ti.i32, ndim=1),
    ):
        """March the particles that came below a plane again, one by one, from impact to impact."""
        for b in range(packs):
            bits = self.group.below[b]
            if bits != 0:
                p = self.group.loaded()
                for lane in range(ti.min(LANES, count - b * LANES)):
                    if (bits >> lane) & 1 == 1:
                        self._advance_lane(p, b, lane, start, interval, steps, flags)

    @ti.func
    def _advance_lane(self, p, b, lane, start, interval, steps, flags: ti.template()):
        dt, t0 = ti.cast(interval / steps, self.group.real), ti.cast(start, self.group.real)
        own = self._own_of(p, b, lane, t0)
        fate = self._component("fate", b, lane, 0)
        temperature = self._component("temperature", b, lane, 0.0)
        before = self._motion_of(b, lane)
        x, y, z, u, v, w, end, warmth, _, reached = self.group.march.advance(
            p, t0, dt, steps, before, own, fate, temperature, Way.CAREFULLY
        )
        if self.group.march.careful_stepper.events.lies(p, before[:3]):
            ti.atomic_add(flags[RESTING], 1)
        aged = self.group.aged(own[0] + ti.cast(interval, self.group.real), reached)
        self._keep(b, lane, [x, y, z, u, v, w], aged, end, warmth, flags)

    @ti.kernel
    def advance_paced(
        self,
        count: ti.i32,
        start: ti.f64,
        interval: ti.f64,
        longest: ti.f64,
        tolerance: ti.f64,
        flags: ti.types.ndarray(dtype=ti.i32, ndim=1),
        counts: ti.types.ndarray(dtype=ti.i64, ndim=1),
    ):
        """Advance particles one by one, each with steps of its own."""
        for slot in range(count):
            p = self.group.loaded()
            b, lane = slot // LANES, slot % LANES
            t0, span = ti.cast(start, self.group.real), ti.cast(interval, self.group.real)
            own = self._own_of(p, b, lane, t0)
            fate = self._component("fate", b, lane, 0)
            temperature = self._component("temperature", b, lane, 0.0)
            x, y, z, u, v, w, end, warmth, pace, taken, tried, reached = self.paced.advance(
                p,
                t0,
                span,
                ti.cast(longest, self.group.real),
                ti.cast(tolerance, self.group.real),
                self._component("pace", b, lane, 0.0),
                self._motion_of(b, lane),
                own,
                fate,
                temperature,
            )
            self._keep(b, lane, [x, y, z, u, v, w], self.group.aged(own[0] + span, reached), end, warmth, flags)
            self.group.state.reals[self.group.state.row("pace"), b][lane] = pace
            ti.atomic_add(counts[0], taken)
            ti.atomic_add(counts[1], tried)

    @ti.func
    def _own_of(self, p, b, lane, t0):
        """What stays the same for a particle during a frame, see `March.advance`."""
        return [
            self._component("age", b, lane, t0),
            self._component("lifetime", b, lane, p[-1][Constant.LIFETIME]),
            self._component("cooling_rate", b, lane, p[-1][Constant.COOLING_RATE]),
            self._component("inverse_mass", b, lane, p[-1][Constant.INVERSE_MASS]),
            b * LANES + lane,
        ]

    @ti.func
    def _motion_of(self, b, lane):
        """Scalars x, y, z, u, v, w of a particle; the last three idle in a first-order group."""
        x, y, z = (
            self.group.state.reals[0, b][lane],
            self.group.state.reals[1, b][lane],
            self.group.state.reals[2, b][lane],
        )
        u, v, w = (
            self._component("u", b, lane, x),
            self._component("v", b, lane, x),
            self._component("w", b, lane, x),
        )
        return [x, y, z, u, v, w]

    @ti.func
    def _keep(self, b, lane, state, age, fate, temperature, flags: ti.template()):
        """Store a particle; one that is not finite keeps its old motion and is dropped or reported."""
        end = fate
        if finite(state):
            for i in ti.static(range(len(self.group.plan.motion_components))):
                self.group.state.reals[i, b][lane] = state[i]
        elif ti.static(self.group.plan.dies.non_finite):
            end = int(Fate.NON_FINITE)
        else:
            ti.atomic_min(flags[FAILED], b * LANES + lane)
        if ti.static(self.group.has("age")):
            self.group.state.reals[self.group.state.row("age"), b][lane] = age
        if ti.static(self.group.march.cools):
            self.group.state.reals[self.group.state.row("temperature"), b][lane] = temperature
        if ti.static(self.group.has("fate")):
            self.group.state.integers[self.group.state.row("fate"), b][lane] = end
            if end > 0:
                flags[DIED] = 1

"""One group of particles with a kernel of its own: just its forces, flows, planes, ageing, cooling and deaths."""

from itertools import accumulate

import numpy as np
import taichi as ti

from particlecli import runtime
from particlecli.dynamics.algebra import bound, choose, finite
from particlecli.dynamics.deaths import Fate
from particlecli.dynamics.group_lanes import GroupLanes
from particlecli.dynamics.group_plan import INTEGER_COMPONENTS, LANES, Constant, GroupPlan
from particlecli.dynamics.group_rest import GroupRest
from particlecli.dynamics.impact_record import ImpactRecord
from particlecli.dynamics.march import March, Way
from particlecli.dynamics.memory import FieldMemory
from particlecli.dynamics.motion import Motion
from particlecli.dynamics.outcome import CAREFULLY, DIED, FAILED, NOBODY, RESTING, Outcome, lowered_flags
from particlecli.dynamics.state import PackedState

PACKS_A_TASK = 32
"""Packs that a thread takes at once: few, so that small groups with much to compute are shared out too."""


@ti.data_oriented
class Group:
    """The particles of a group and the kernels that advance them.

    A kernel loads a pack, takes all the steps of a frame in registers and stores it: state is read and written once
    a frame. Numbers of the scene are read from a table, so scenes that differ only in numbers share a kernel.

    Args:
        plan: what the group needs.
        motion: its equations of motion.
        real: type of its numbers, ti.f32 or ti.f64.
        memory: of the system; the group is ready once that is open.
    """

    def __init__(self, plan: GroupPlan, motion: Motion, real, memory: FieldMemory) -> None:
        runtime.use(self)
        self.plan = plan
        self.real = real
        self.state = PackedState(plan.components, plan.capacity, real, memory)
        self.motion = motion
        most = plan.bearing_impacts
        self.impacts = ImpactRecord(self.state, most, real, memory) if most else None
        self.march = March(plan, motion, real, self.impacts, memory)
        lists = [list(term.parameters()) for term in self.march.terms] + [list(plan.constants)]
        ends = list(accumulate(len(values) for values in lists))
        self.spans = [(end - len(values), end) for end, values in zip(ends, lists, strict=True)]
        if self.march.locates:
            self.below = ti.field(ti.i32, shape=max(1, -(-plan.capacity // LANES)))
        self.lanes = GroupLanes(self)
        self.rest = GroupRest(self)
        self.table = memory.table(real, np.concatenate(lists))

    def has(self, component: str) -> bool:
        """Whether the group keeps this component for each particle."""
        return component in self.plan.components

    def compile(self) -> None:
        """Compile the kernels that advance particles, by advancing none."""
        flags = lowered_flags()
        if self.plan.adaptive:
            self.lanes.advance_paced(0, 0.0, 1.0, 1.0, 1.0, flags, np.zeros(2, dtype=np.int64))
            return
        self._advance(0, 0, 0.0, 1.0, 1, flags)
        if self.march.locates:
            self.lanes.advance_carefully(0, 0, 0.0, 1.0, 1, flags)

    def advance(self, start: float, interval: float, steps: int) -> Outcome:
        """Advance all particles from time `start` by `interval`, both in s; in equal steps or at their own pace."""
        flags = lowered_flags()
        count, evaluations = self.state.count, self.plan.scheme.evaluations
        counts = np.array([count * steps, count * steps], dtype=np.int64)
        if self.plan.adaptive:
            counts[:] = 0
            limits = self.plan.longest_step, self.plan.tolerance
            self.lanes.advance_paced(count, start, interval, *limits, flags, counts)
        else:
            self._advance(self.state.packs, count, start, interval, steps, flags)
            if flags[CAREFULLY] and self.march.calms and self.rest.pays:
                self.rest.advance_calmly(self.state.packs, count, start, interval, steps, flags)
            if flags[CAREFULLY]:
                self.lanes.advance_carefully(self.state.packs, count, start, interval, steps, flags)
            self.rest.learn(int(flags[RESTING]), steps)
        return Outcome(
            failed_slot=None if flags[FAILED] == NOBODY else int(flags[FAILED]),
            died=bool(flags[DIED]),
            steps=int(counts[0]),
            evaluations=int(counts[1]) * evaluations,
        )

    def derivative(self, time: float) -> np.ndarray:
        """Time derivatives of the components of motion and the temperature, shape (components, count), f64."""
        out = np.zeros((len(self.plan.solver_components), self.state.count))
        if self.state.count:
            self._differentiate(self.state.packs, self.state.count, time, out)
        return out

    @ti.func
    def loaded(self):
        """The parameters of each term and the constants, in local variables."""
        return [
            [bound(self.table[i]) for i in ti.static(range(self.spans[j][0], self.spans[j][1]))]
            for j in ti.static(range(len(self.spans)))
        ]

    @ti.func
    def component(self, name: ti.template(), b, constant):
        """A component of pack b where the group keeps it, else the constant that stands for it."""
        if ti.static(self.has(name)):
            if ti.static(name in INTEGER_COMPONENTS):
                return self.state.integers[self.state.row(name), b]
            else:
                return self.state.reals[self.state.row(name), b]
        return constant

    @ti.func
    def _motion(self, b):
        """Packs x, y, z, u, v, w; the last three idle in a first-order group."""
        x, y, z = self.component("x", b, 0.0), self.component("y", b, 0.0), self.component("z", b, 0.0)
        u, v, w = self.component("u", b, x), self.component("v", b, x), self.component("w", b, x)
        return [x, y, z, u, v, w]

    @ti.kernel
    def _advance(
        self,
        packs: ti.i32,
        count: ti.i32,
        start: ti.f64,
        interval: ti.f64,
        steps: ti.i32,
        flags: ti.types.ndarray(dtype=ti.i32, ndim=1),
    ):
        ti.loop_config(block_dim=PACKS_A_TASK)
        for b in range(packs):
            new = self.marched(b, start, interval, steps, Way.FREELY)
            clear = new[8] >= 0.0
            end = new[6]
            taken = ti.select(clear & finite(new[:6]), 1, 0)
            below = 0
            if taken.min() == 0:
                for lane in ti.static(range(LANES)):
                    if (b * LANES + lane < count) & (taken[lane] == 0):
                        if new[8][lane] < 0.0:
                            flags[CAREFULLY] = 1
                            below = below | (1 << lane)
                        elif ti.static(self.plan.dies.non_finite):
                            end[lane] = int(Fate.NON_FINITE)
                        else:
                            ti.atomic_min(flags[FAILED], b * LANES + lane)
            if ti.static(self.march.locates):
                self.below[b] = below
            for i in ti.static(range(len(self.plan.motion_components))):
                self.state.reals[i, b] = ti.select(taken == 1, new[i], self.state.reals[i, b])
            self.keep(b, count, clear, end, new[7], new[9], flags)

    @ti.func
    def marched(self, b, start, interval, steps, way: ti.template()):
        """What `March.advance` makes of pack b in an interval, s; the last is the age at its end."""
        p = self.loaded()
        dt, t0 = ti.cast(interval / steps, self.real), ti.cast(start, self.real)
        age = self.component("age", b, t0)
        own = [
            age,
            self.component("lifetime", b, p[-1][Constant.LIFETIME]),
            self.component("cooling_rate", b, p[-1][Constant.COOLING_RATE]),
            self.component("inverse_mass", b, p[-1][Constant.INVERSE_MASS]),
        ]
        fate, temperature = self.component("fate", b, 0), self.component("temperature", b, 0.0)
        new = self.march.advance(p, t0, dt, steps, self._motion(b), own, fate, temperature, way)
        return new[:9] + [self.aged(age + ti.cast(interval, self.real), new[9])]

    @ti.func
    def keep(self, b, count, kept, fate, temperature, age, flags: ti.template()):
        """Store what changes besides motion for the lanes of pack b in the mask `kept`; say whether any died."""
        if ti.static(self.has("age")):
            row = ti.static(self.state.row("age"))
            self.state.reals[row, b] = ti.select(kept, age, self.state.reals[row, b])
        if ti.static(self.march.cools):
            row = ti.static(self.state.row("temperature"))
            self.state.reals[row, b] = ti.select(kept, temperature, self.state.reals[row, b])
        if ti.static(self.has("fate")):
            row = ti.static(self.state.row("fate"))
            self.state.integers[row, b] = ti.select(kept, fate, self.state.integers[row, b])
            if ti.select(kept, fate, 0).max() > 0:
                for lane in ti.static(range(LANES)):
                    if (b * LANES + lane < count) & kept[lane] & (fate[lane] > 0):
                        flags[DIED] = 1

    @ti.func
    def aged(self, age, reached):
        """The age after an interval; at death where that bears children."""
        if ti.static(self.plan.bears_at_death):
            return reached
        return age

    @ti.kernel
    def _differentiate(self, packs: ti.i32, count: ti.i32, time: ti.f64, out: ti.types.ndarray(dtype=ti.f64, ndim=2)):
        for b in range(packs):
            p = self.loaded()
            t = ti.cast(time, self.real)
            state = self._motion(b)
            temperature = self.component("temperature", b, 0.0)
            rate = self.component("cooling_rate", b, p[-1][Constant.COOLING_RATE])
            inverse_mass = self.component("inverse_mass", b, p[-1][Constant.INVERSE_MASS])
            fate = self.component("fate", b, 0)
            slopes = self.motion.derivative(p, state, t, [inverse_mass])
            for i in ti.static(range(len(self.plan.motion_components))):
                self._put(out, i, b, count, 0.0 * state[0] + slopes[i], fate == 0)
            if ti.static(self.has("temperature")):
                change = self.march.cooling_rate(p, temperature, rate)
                self._put(out, len(self.plan.motion_components), b, count, change, True)

    @ti.func
    def _put(self, out: ti.template(), row, b, count, values, moves: ti.template()):
        """Write the lanes of a pack that hold particles into a row, zero for those that do not move."""
        held = choose(moves if ti.static(self.has("fate")) else True, values, 0.0 * values)
        for lane in ti.static(range(LANES)):
            if b * LANES + lane < count:
                out[row, b * LANES + lane] = held[lane]

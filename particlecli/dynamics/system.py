"""System: a plan brought to life. Advances the particles from frame to frame; the solver interface."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli import runtime
from particlecli.dynamics.birth_table import BirthTable
from particlecli.dynamics.births import ParticleBirths
from particlecli.dynamics.failure import failed_before, failure
from particlecli.dynamics.fixed import FixedGroup
from particlecli.dynamics.flows import flow_terms
from particlecli.dynamics.forces import force_term
from particlecli.dynamics.group import Group
from particlecli.dynamics.group_frames import OPTIONAL_FIELDS, frame_of, frame_of_nobody
from particlecli.dynamics.group_plan import GroupPlan, medium
from particlecli.dynamics.kinship import by_generation
from particlecli.dynamics.memory import FieldMemory
from particlecli.dynamics.motion import Motion
from particlecli.dynamics.newborn import columns_of
from particlecli.dynamics.offspring import Offspring
from particlecli.dynamics.outcome import Outcome
from particlecli.dynamics.plan import Plan
from particlecli.errors import SimulationError
from particlecli.frame import Frame, GroupFrame

if TYPE_CHECKING:
    from particlecli.dynamics.coupled.system import CoupledSystem

BIRTHS_AT_A_TIME = 1 << 20
"""Rows of a birth table drawn at once, so that tables of many millions need little memory."""


class System:
    """The particles of a scene in phase space.

    As a first-order system dy/dt = f(y, t) it has the classic solver interface (Witkin & Baraff, Physically Based
    Modeling): `dim`, `get_state`, `set_state`, `derivative`. Its state vector holds, group by group, the components
    x, y, z[, u, v, w][, temperature] of all living particles, each component in one piece.

    Args:
        plan: what to build.
        retraces: whether a particle that fails is followed once more step by step, to tell where it was last well.

    Attributes:
        plan: what was built.
        groups: what moves, by name.
        coupled: those among them whose particles act on each other, as one system; none if there are none.
        fixed: the groups that rest in coordinate frames, by name.
        time: s.
        births: how many were born so far, by group.
        deaths: how many died so far, by group and cause.
        particle_steps: steps taken, summed over all particles.
        group_evaluations: evaluations of the equations of motion, summed over particles, by group that moves.
    """

    def __init__(self, plan: Plan, *, retraces: bool = True) -> None:
        runtime.use(self, wears=True)
        self.plan = plan
        self._retraces = retraces
        self._real = ti.f64 if plan.scene.precision == "double" else ti.f32
        memory = FieldMemory()
        self._flows = {name: flow_terms(terms, plan.scene.seed) for name, terms in plan.flows.items()}
        self._place_tables(memory)
        self.groups = {group.name: self._group(group, memory) for group in plan.groups}
        self.coupled = self._couple(memory)
        self._offspring = self._make_offspring()
        self._order = [name for name in by_generation(plan.scene) if name in self.groups]
        self.fixed = {name: FixedGroup(plan.scene, name) for name in plan.fixed}
        memory.open()
        self.restart()

    def _couple(self, memory: FieldMemory) -> "CoupledSystem | None":
        bound = {name: group for name, group in self.groups.items() if group.plan.coupled}
        if not bound:
            return None
        from particlecli.dynamics.coupled.system import CoupledSystem  # takes a while, and most scenes need none

        return CoupledSystem(bound, self.plan.couplings, self._real, memory)

    def restart(self) -> None:
        """Go back to t = 0, to the particles that are there from the beginning."""
        self.time = 0.0
        self.particle_steps = 0
        self.group_evaluations = dict.fromkeys(self.groups, 0)
        self.births = dict.fromkeys(self.plan.scene.groups, 0)
        self.births |= {name: group.count for name, group in self.fixed.items()}
        self.deaths: dict[str, dict[str, int]] = {name: {} for name in self.plan.scene.groups}
        for name, group in self.groups.items():
            group.state.count = 0
            births = group.plan.births
            if isinstance(births, ParticleBirths):
                for first in range(0, births.total, BIRTHS_AT_A_TIME):
                    table = births.table(first, min(first + BIRTHS_AT_A_TIME, births.total))
                    self._bear(name, _at_start(group.plan, table) if group.plan.pins else table)
        self._born_until = -np.inf
        if self.coupled:
            self.coupled.restart()

    def _place_tables(self, memory: FieldMemory) -> None:
        for terms in self._flows.values():
            for term in terms:
                if term.table is not None:
                    term.rows = memory.table(self._real, term.table)

    def _group(self, plan: GroupPlan, memory: FieldMemory) -> Group:
        motion = Motion(
            flows=[self._flows[name] for name in plan.flows],
            forces=[force_term(force, self.plan.scene.frames) for force in plan.forces],
            media=[None if (flow := medium(force)) is None else plan.flows.index(flow) for force in plan.forces],
            carrier=None if plan.carrier is None else plan.flows.index(plan.carrier),
        )
        return Group(plan, motion, self._real, memory)

    def _make_offspring(self) -> dict[str, Offspring]:
        births = {name: group.plan.births for name, group in self.groups.items()}
        parents = dict.fromkeys(brood.parent for brood in self.plan.broods)
        return {
            name: Offspring(self.groups[name], [each for each in self.plan.broods if each.parent == name], births)
            for name in parents
        }

    @property
    def evaluations(self) -> int:
        """Evaluations of the equations of motion, summed over all particles."""
        return sum(self.group_evaluations.values())

    @property
    def alive(self) -> int:
        """How many particles are alive."""
        moving = sum(group.state.count for group in self.groups.values())
        return moving + sum(group.count for group in self.fixed.values())

    def compile(self) -> None:
        """Compile the kernels that frames need, so that their time can be told apart."""
        for group in self.groups.values():
            if not group.plan.coupled:
                group.compile()
        if self.coupled:
            self.coupled.compile()

    def advance(self, until: float) -> None:
        """Advance from the present time to `until`, s, in the plan's number of equal steps.

        Raises:
            SimulationError: a particle is not finite any more.
        """
        interval = until - self.time
        for name, group in self.groups.items():
            if not isinstance(group.plan.births, ParticleBirths):
                self._bear(name, group.plan.births.between(self._born_until, until))
        self._born_until = until
        if interval > 0:
            steps = self.plan.steps_per_frame
            for name in self._order:
                group = self.groups[name]
                if group.state.count and not group.plan.coupled:
                    offspring = self._offspring.get(name)
                    if offspring:
                        offspring.begin()
                    self._note(name, group, group.advance(self.time, interval, steps), interval)
            if self.coupled:
                for name, outcome in self.coupled.advance(self.time, interval, steps).items():
                    self._note(name, self.groups[name], outcome, interval)
        self.time = until

    def _note(self, name: str, group: Group, outcome: Outcome, interval: float) -> None:
        """Take note of what became of a group in an interval."""
        self.particle_steps += outcome.steps
        self.group_evaluations[name] += outcome.evaluations
        if outcome.failed_slot is not None:
            if self._retraces:
                raise failure(self, group, outcome.failed_slot, interval)
            raise failed_before(group, self.time + interval)
        if name in self._offspring:
            for child, table in self._offspring[name].born(self.time):
                self._bear(child, table)
        if outcome.died:
            for cause, number in group.state.bury().items():
                self.deaths[name][cause] = self.deaths[name].get(cause, 0) + number

    def _bear(self, name: str, table: BirthTable) -> None:
        """Put newborn particles behind the living; their age is negative until they are born."""
        if len(table.ids) == 0:
            return
        group = self.groups[name]
        count = len(table.ids)
        if group.state.count + count > group.state.capacity:
            raise SimulationError(
                f"group {name}: {group.state.count + count:,} particles would be alive at t = {self.time:.6g} s, "
                f"but the scene was planned for at most {group.state.capacity:,}"
            )
        group.state.append(columns_of(table, self.time))
        self.births[name] += count

    def frame(self, index: int, fields: Mapping[str, frozenset[str]] | None = None) -> Frame:
        """The present state as plain arrays, a copy; `fields` as in `Simulation`."""
        groups = {
            name: self._group_frame(name, OPTIONAL_FIELDS if fields is None else fields.get(name, frozenset()))
            for name in self.plan.scene.groups
        }
        return Frame(index=index, time=self.time, groups=groups)

    def _group_frame(self, name: str, fields: frozenset[str]) -> GroupFrame:
        if name in self.fixed:
            return self.fixed[name].frame(self.time, fields)
        spec = self.plan.scene.groups[name]
        if name not in self.groups:
            return frame_of_nobody(spec, fields)
        return frame_of(self.groups[name], spec.lifetime, self.time, fields)

    @property
    def dim(self) -> int:
        """Length of the state vector."""
        return sum(len(group.plan.solver_components) * group.state.count for group in self.groups.values())

    def get_state(self) -> NDArray[np.float64]:
        """The state vector, shape (dim,)."""
        parts = [group.state.read(group.plan.solver_components).ravel() for group in self.groups.values()]
        return np.concatenate([np.empty(0), *parts]).astype(np.float64)

    def set_state(self, state: NDArray[np.float64]) -> None:
        """Replace the state vector; the population stays.

        Raises:
            ValueError: it does not have the shape (dim,).
        """
        if np.shape(state) != (self.dim,):
            raise ValueError(f"the state vector has shape ({self.dim},), not {np.shape(state)}")
        start = 0
        for group in self.groups.values():
            names = group.plan.solver_components
            stop = start + len(names) * group.state.count
            group.state.overwrite(names, state[start:stop].reshape(len(names), -1))
            start = stop

    def derivative(self, time: float) -> NDArray[np.float64]:
        """dy/dt of the state vector at a time in s: velocities, accelerations, cooling; planes do not act here."""
        coupled = self.coupled.derivative(time) if self.coupled else {}
        parts = []
        for name, group in self.groups.items():
            if name not in coupled:
                parts.append(group.derivative(time))
                continue
            parts.append(coupled[name])
            if group.has("temperature"):
                parts.append(group.derivative(time)[-1:])
        return np.concatenate([np.empty(0), *(part.ravel() for part in parts)])


def _at_start(plan: GroupPlan, table: BirthTable) -> BirthTable:
    from particlecli.dynamics.coupled.pins import at_start

    return at_start(plan, table)

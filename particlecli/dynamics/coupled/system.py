"""CoupledSystem: all particles that act on each other, advanced frame by frame with one step for all."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.coupled.ending import DIED, FAILED, Ending
from particlecli.dynamics.coupled.implicit_stages import ImplicitStages
from particlecli.dynamics.coupled.kernels import StageKernels
from particlecli.dynamics.coupled.krylov import Krylov
from particlecli.dynamics.coupled.launched import LaunchedMarch, Pace, make_sure
from particlecli.dynamics.coupled.located import LocatedMarch
from particlecli.dynamics.coupled.motion import CoupledMotion
from particlecli.dynamics.coupled.newton import Newton
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.coupled.registry import coupled_term
from particlecli.dynamics.coupled.serial import SerialMarch
from particlecli.dynamics.coupled.sph import Sph
from particlecli.dynamics.coupled.stages import stages
from particlecli.dynamics.coupled.step import Step
from particlecli.dynamics.group import Group
from particlecli.dynamics.group_plan import LANES, GroupPlan
from particlecli.dynamics.memory import FieldMemory
from particlecli.dynamics.outcome import NOBODY, Outcome
from particlecli.dynamics.plan import Coupling, acts_in_one_kernel


class CoupledSystem:
    """The groups of a scene that coupled forces act on, as one system.

    Args:
        groups: those groups, in the scene's order.
        couplings: the forces between particles.
        real: type of numbers, ti.f32 or ti.f64.
        memory: of the system; all is ready once that is open.

    Attributes:
        points: all particles, as the forces see them.
        terms: the forces between them.
        tolerance: error that an adaptive scheme may make in a step, m and m/s.
    """

    def __init__(
        self, groups: Mapping[str, Group], couplings: tuple[Coupling, ...], real: object, memory: FieldMemory
    ) -> None:
        self._groups = list(groups.values())
        plans = [group.plan for group in self._groups]
        plan = plans[0]
        self._longest, self.tolerance = plan.longest_step, plan.tolerance
        self.points = Points({name: group.plan.capacity for name, group in groups.items()}, real, memory)
        self.terms = [
            coupled_term(each.force, self.points, [self.points.index(name) for name in each.groups], plans)
            for each in couplings
        ]
        self._prepared = [term for term in self.terms if term.needs_preparation]
        motion, parts = CoupledMotion(self._groups, self.terms, self.points), stages(plan.scheme, self.points)
        serial = acts_in_one_kernel(plans, couplings)
        step = Step(motion, parts, Ending(self._groups, self.points, parts.base))
        self._times = parts.times
        self._eventful = step.eventful
        self._stepper = self._groups[0].march.stepper if plan.adaptive else None
        self._kernels = StageKernels(step)
        self._launched = LaunchedMarch(self._kernels, self._times, plan.scheme, self._prepare)
        self._newton = self._make_newton(step, parts, plan) if isinstance(parts, ImplicitStages) else None
        march = LocatedMarch if step.locates else SerialMarch
        self._serial = march(step, self._stepper) if serial else None
        self._pace = Pace()
        self._arranged: list[int] = []

    def _make_newton(self, step: Step, parts: ImplicitStages, plan: GroupPlan) -> Newton:
        def end(start: float, now: float, h: float) -> None:
            if self._eventful:
                self._kernels.end(self.points.packs, start, now, h)

        return Newton(
            Krylov(step, parts), parts, self._prepare, self._kernels.revert, end, plan.scheme.order, plan.real_bytes
        )

    def restart(self) -> None:
        """Begin anew: forget the pace, and what forces have kept."""
        self._pace = Pace()
        for term in self.terms:
            term.restart()

    def compile(self) -> None:
        """Compile the kernels that frames need, by advancing nobody."""
        self._arrange([0] * len(self._groups))
        flags = self._flags()
        if self._serial:
            self._march(0.0, 1.0, 1, flags)
            self.restart()
        else:
            self._kernels.load(0)
            if self._newton:
                self._newton.compile()
            else:
                self._kernels.stage(0, 0, 0, 0, 0, 0.0, 0.0, 1.0)
            if self._stepper:
                self._kernels.error(0, 1.0)
                self._kernels.revert(0)
                self._kernels.end(0, 0.0, 0.0, 1.0)
            self._kernels.store(0, 1.0, flags)

    def advance(self, start: float, interval: float, steps: int) -> dict[str, Outcome]:
        """Advance all particles from time `start` by `interval`, s, in equal steps or by the estimated error.

        Where a particle is not finite any more, all keep their old state.

        Raises:
            SimulationError: an adaptive scheme cannot go on.
        """
        self._arrange([group.state.count for group in self._groups])
        flags = self._flags()
        if self._serial:
            taken, tried = self._march(start, interval, steps, flags)
        else:
            taken, tried = self._march_by_launches(start, interval, steps, flags)
        return {
            name: Outcome(
                failed_slot=None if flags[g, FAILED] == NOBODY else int(flags[g, FAILED]),
                died=bool(flags[g, DIED]),
                steps=taken * int(self.points.populations[g]),
                evaluations=tried * (1 if self._newton else len(self._times)) * int(self.points.populations[g]),
            )
            for g, name in enumerate(self.points.names)
        }

    def _flags(self) -> NDArray[np.int32]:
        flags = np.zeros((len(self._groups), 2), np.int32)
        flags[:, FAILED] = NOBODY
        return flags

    def retrace(self, start: float, interval: float, steps: int) -> int:
        """Go step by step through an interval in which a particle failed; how many steps all were well."""
        dt = interval / steps
        for s in range(steps):
            outcomes = self.advance(start + s * dt, dt, 1)
            if any(outcome.failed_slot is not None for outcome in outcomes.values()):
                return s
        return steps

    def derivative(self, time: float) -> dict[str, NDArray[np.float64]]:
        """By group, time derivatives of the components of motion, shape (6, count)."""
        self._gather()
        self._prepare(time)
        out = np.zeros((6, self.points.packs * LANES))
        self._kernels.differentiate(self.points.packs, time, out)
        return self._by_group(out)

    def potential_energies(self, time: float) -> dict[str, NDArray[np.float64]]:
        """By group, the share of each particle in the energy of the forces between particles, J, shape (count,).

        Of a pair each has half; forces without a potential do not count.
        """
        self._gather()
        for term in self._prepared:
            term.prepare_potential(time)
        energies, part = np.zeros((2, self.points.packs, LANES))
        for j, term in enumerate(self.terms):
            if term.has_potential:
                self._kernels.potential(j, self.points.packs, time, part)
                energies += part
        return self._by_group(energies.reshape(-1))

    def fluids(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """By group that is an sph fluid, `density`, kg/m³, and `pressure`, Pa, of its particles, shape (count,)."""
        self._gather()
        found: dict[str, dict[str, NDArray[np.float64]]] = {}
        for term in self.terms:
            if isinstance(term, Sph):
                density, pressure = (self._by_group(values) for values in term.fluid())
                names = [self.points.names[group] for group in term.groups]
                found |= {name: {"density": density[name], "pressure": pressure[name]} for name in names}
        return found

    def _by_group(self, values: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
        """Values of particles, shape (…, 16 packs), for each group its own."""
        starts = self.points.first_packs * LANES
        return {
            name: values[..., starts[g] : starts[g] + self.points.populations[g]]
            for g, name in enumerate(self.points.names)
        }

    def _gather(self) -> None:
        self._arrange([group.state.count for group in self._groups])
        self._kernels.load(self.points.packs)

    def _arrange(self, populations: list[int]) -> None:
        if populations != self._arranged:
            self.points.arrange(populations)
            self._arranged = populations
            for term in self.terms:
                term.rearranged()

    def _prepare(self, time: float) -> None:
        for term in self._prepared:
            term.prepare(time)

    def _march(self, start: float, interval: float, steps: int, flags: NDArray[np.int32]) -> tuple[int, int]:
        """In one launch; how many steps were taken and tried."""
        assert self._serial
        packs, record = self.points.packs, np.array([self._pace.liked, self._pace.last, 0.0, 0.0, 0.0])
        if not self._stepper:
            self._serial.evenly(packs, start, interval, steps, flags, record)
            return steps, int(record[3])
        self._serial.paced(packs, start, interval, self._longest, self.tolerance, flags, record)
        self._pace = Pace(*record[:2])
        make_sure(record[4] >= interval, start + record[4])
        return int(record[2]), int(record[3])

    def _march_by_launches(
        self, start: float, interval: float, steps: int, flags: NDArray[np.int32]
    ) -> tuple[int, int]:
        """Launch by launch; how many steps were taken and tried."""
        packs = self.points.packs
        self._kernels.load(packs)
        taken = tried = steps
        if self._stepper:
            taken, tried = self._launched.paced(packs, start, interval, self._longest, self.tolerance, self._pace)
        elif self._newton:
            lengths = [(s * interval / steps, interval / steps) for s in range(steps)]
            tried = sum(self._newton.step(packs, start, now, h) for now, h in lengths)
        else:
            self._launched.evenly(packs, start, interval, steps)
        for term in self._prepared:
            term.settle()
        self._kernels.store(packs, interval, flags)
        return taken, tried

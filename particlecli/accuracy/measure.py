"""What known answers are about, measured on a simulation: positions, velocities, energy, any quantity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.masses import masses
from particlecli.scene.expression import Expression
from particlecli.scene.known_answers import NAMES_OF_FLUID
from particlecli.simulate import Simulation

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]


@dataclass(frozen=True)
class Sample:
    """Some particles of a group of a simulation, now.

    Attributes:
        simulation, group: whose.
        ids: numbers of the particles, shape (n,).
        positions, velocities: shape (n, 3), m and m/s; a first-order group has no velocities.
    """

    simulation: Simulation
    group: str
    ids: Ids
    positions: Doubles
    velocities: Doubles | None

    @classmethod
    def of(cls, simulation: Simulation, group: str) -> Sample:
        """All particles of a group that are alive."""
        frame = simulation.system.frame(0).groups[group]
        velocities = None if frame.velocities is None else frame.velocities.astype(np.float64)
        return cls(simulation, group, frame.ids, frame.positions.astype(np.float64), velocities)

    def chosen(self, ids: Ids) -> Sample:
        """Those of given numbers, all of them alive."""
        places = np.searchsorted(self.ids, ids)
        velocities = None if self.velocities is None else self.velocities[places]
        return Sample(self.simulation, self.group, ids, self.positions[places], velocities)

    @property
    def plan(self) -> GroupPlan:
        """What was worked out for the group."""
        return next(plan for plan in self.simulation.plan.groups if plan.name == self.group)

    def quantity(self, expression: Expression) -> Doubles:
        """The values of an expression of x, y, z, u, v, w, t, speed, distance, density, pressure, shape (n,)."""
        names = {"t": self.simulation.system.time, **dict(zip("xyz", self.positions.T, strict=True))}
        if self.velocities is not None:
            names |= dict(zip("uvw", self.velocities.T, strict=True))
            names["speed"] = np.linalg.norm(self.velocities, axis=1)
        if "distance" in expression.names:
            start = self.plan.births.of(self.ids).positions.T
            names["distance"] = np.linalg.norm(self.positions - start, axis=1)
        if expression.names & NAMES_OF_FLUID:
            names |= self._fluid()
        return np.broadcast_to(expression.evaluate(names), len(self.ids)).astype(np.float64)

    def _fluid(self) -> dict[str, Doubles]:
        """Density, kg/m³, and pressure, Pa, of an sph fluid."""
        assert self.simulation.system.coupled
        found = self.simulation.system.coupled.fluids()[self.group]
        return {name: values[self._places()] for name, values in found.items()}

    def energy(self) -> float:
        """Kinetic and potential energy of them all, J; a force without a potential does not count."""
        from particlecli.dynamics.probe import Probe  # brings Taichi, which the simulation has started

        if self.velocities is None:
            raise ValueError("a first-order group has no energy")
        mass = masses(self.plan, self.ids)
        states = np.concatenate([self.positions, self.velocities], axis=1).T
        times = np.full(len(self.ids), self.simulation.system.time)
        probe = Probe(self.simulation.system.groups[self.group].motion, self.simulation.scene.precision)
        potential = probe.potential(states, times, 1.0 / mass)
        energy = float(mass @ (0.5 * (self.velocities**2).sum(axis=1) + potential))
        return energy + self._shared_energy()

    def _shared_energy(self) -> float:
        """The share in the potential energy of forces between particles, J; of a pair each has half."""
        system = self.simulation.system
        if system.coupled is None or not self.plan.coupled:
            return 0.0
        shares = system.coupled.potential_energies(system.time)[self.group]
        return float(shares[self._places()].sum())

    def _places(self) -> Ids:
        """The places of the particles among all that are alive."""
        return np.searchsorted(self.simulation.system.frame(0, {}).groups[self.group].ids, self.ids)

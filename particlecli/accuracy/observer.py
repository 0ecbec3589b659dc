"""What a recording shows beside the particles: how many live, what they died of, energy and momentum."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.masses import masses
from particlecli.frame import Frame, GroupFrame
from particlecli.simulate import Simulation

if TYPE_CHECKING:
    from particlecli.dynamics.probe import Probe

Doubles = NDArray[np.float64]
Series = dict[str, dict[str, float]]

AXES = ("x", "y", "z")


class Observer:
    """Watches a simulation.

    Args:
        simulation: one whose frames carry the velocities of newtonian groups.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._plans = {plan.name: plan for plan in simulation.plan.groups if plan.newtonian}
        self._probes = {name: probe for name, plan in self._plans.items() if (probe := _probe(simulation, plan))}
        coupled = simulation.system.coupled
        self._coupled = coupled if coupled and any(term.has_potential for term in coupled.terms) else None

    def series(self, frame: Frame) -> Series:
        """Numbers about a frame that the simulation has just made, by plot and name.

        `alive` by group; `deaths` so far by group and cause; of the newtonian groups `energy` (J): kinetic,
        and, where some force has a potential, potential and total; and `momentum` (kg m/s) by axis.
        """
        series: Series = {"alive": {name: float(len(group)) for name, group in frame.groups.items()}}
        series["deaths"] = {
            f"{group}/{cause}": float(count)
            for group, causes in self._simulation.deaths.items()
            for cause, count in causes.items()
        }
        if self._plans:
            series["energy"], series["momentum"] = self._motion(frame)
        return series

    def springs(self) -> dict[str, NDArray[np.int64]]:
        """By group, the ids of the particles that whole springs join now, shape (n, 2)."""
        coupled = self._simulation.system.coupled
        if coupled is None:
            return {}
        from particlecli.dynamics.coupled.springs import Springs  # brings Taichi, which the simulation has started

        found: dict[str, list[NDArray[np.int64]]] = {}
        for term in coupled.terms:
            if isinstance(term, Springs):
                for place, pairs in zip(term.groups, term.joined(), strict=True):
                    found.setdefault(coupled.points.names[place], []).append(pairs)
        return {name: np.concatenate(pairs) for name, pairs in found.items()}

    def _motion(self, frame: Frame) -> tuple[dict[str, float], dict[str, float]]:
        kinetic, potential, momentum = 0.0, 0.0, np.zeros(3)
        for name, plan in self._plans.items():
            group = frame.groups[name]
            assert group.velocities is not None
            mass = masses(plan, group.ids)
            velocities = group.velocities.T.astype(np.float64)
            kinetic += 0.5 * float(mass @ (velocities**2).sum(axis=0))
            momentum += velocities @ mass
            if name in self._probes:
                potential += self._potential(self._probes[name], group, velocities, mass, frame.time)
        if self._coupled:
            potential += sum(float(shares.sum()) for shares in self._coupled.potential_energies(frame.time).values())
        energy = {"kinetic": kinetic}
        if self._probes or self._coupled:
            energy |= {"potential": potential, "total": kinetic + potential}
        return energy, dict(zip(AXES, momentum.tolist(), strict=True))

    def _potential(self, probe: Probe, group: GroupFrame, velocities: Doubles, mass: Doubles, time: float) -> float:
        states = np.concatenate([group.positions.T.astype(np.float64), velocities])
        return float(mass @ probe.potential(states, np.full(len(group), time), 1.0 / mass))


def _probe(simulation: Simulation, plan: GroupPlan) -> Probe | None:
    motion = simulation.system.groups[plan.name].motion
    if not any(force.has_potential for force in motion.forces):
        return None
    from particlecli.dynamics.probe import Probe  # brings Taichi, which the simulation has started

    return Probe(motion, simulation.scene.precision)

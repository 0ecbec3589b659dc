"""Energy, momentum and angular momentum of particles that act on each other: how far they drift where they are kept."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from particlecli.accuracy import prices
from particlecli.accuracy.energy import conserves_energy
from particlecli.accuracy.observer import Observer
from particlecli.dynamics.births import ParticleBirths
from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.masses import masses
from particlecli.scene.forces import Attraction, Force, LennardJones, Springs

if TYPE_CHECKING:
    from particlecli.frame import Frame
    from particlecli.simulate import Simulation

Doubles = NDArray[np.float64]

LOOKS, FEWEST = 16, 4
"""Frames at which is looked beside the first, at most and at least."""

PART = 0.5
"""What energy may cost, in parts of all that estimates may: positions come first."""

ENERGY = 0.1
"""The price of loading the kernels of potential energies, s, see `prices`."""


class Conserved:
    """Watches those quantities of a simulation that its forces keep; what they drift by is the scheme's error.

    Of a scene of which some particles do not act on others, and where particles come or go, nothing is said. Energy is
    left out where it would cost more than a part of `prices.SHARE` of what is foreseen of the run.

    Args:
        simulation: not advanced yet.
        besides: the price of what the run makes beside simulating.

    Attributes:
        names: the quantities.
        price: of watching them, s.
    """

    def __init__(self, simulation: Simulation, besides: prices.Besides | None = None) -> None:
        self._simulation = simulation
        self._plans = {plan.name: plan for plan in simulation.plan.groups}
        self.names, self.price, looks = _kept(simulation), 0.0, LOOKS
        if "energy" in self.names:
            looks = self._energy_looks(besides or prices.Besides())
        self._observer = Observer(simulation) if "energy" in self.names else None
        last = simulation.scene.frame_count - 1
        self._frames = {round(number * last / looks) for number in range(looks + 1)}
        self._values: dict[str, list[Doubles]] = {name: [] for name in self.names}
        self._scales = dict.fromkeys(self.names, 0.0)

    def _energy_looks(self, besides: prices.Besides) -> int:
        """At how many frames energy can be paid for; if at too few, it is not looked at."""
        plan = self._simulation.plan
        left = PART * prices.SHARE * (besides.fixed + prices.foreseen(plan)) - ENERGY
        each = prices.CALL + prices.together(plan)
        looks = int(min(LOOKS, left / each - 1.0))
        if looks < FEWEST:
            self.names.remove("energy")
            return LOOKS
        self.price = ENERGY + (looks + 1) * each
        return looks

    def watch(self, frame: Frame) -> None:
        """Note the quantities at a frame that the simulation has just made."""
        if not self.names or frame.index not in self._frames:
            return
        whole = self._simulation.system.frame(frame.index)
        motions = [self._motion(whole, name) for name in self._plans]
        x, v, m = (np.concatenate(parts) for parts in zip(*motions, strict=True))
        momenta = m[:, None] * v
        self._note("momentum", momenta.sum(axis=0), np.linalg.norm(momenta, axis=1).sum())
        turning = np.cross(x, momenta)
        self._note("angular momentum", turning.sum(axis=0), np.linalg.norm(turning, axis=1).sum())
        if self._observer:
            energy = self._observer.series(whole)["energy"]
            self._note("energy", np.array([energy["total"]]), energy["kinetic"])

    def result(self) -> dict[str, float]:
        """By quantity the largest drift, in parts of Σ m |v|, of Σ m |x × v|, and of the largest kinetic energy."""
        drifts = {}
        for name, values in self._values.items():
            away = np.linalg.norm(np.array(values) - values[0], axis=1).max() if values else 0.0
            if self._scales[name] > 0.0:
                drifts[name] = float(away / self._scales[name])
        return drifts

    def _motion(self, frame: Frame, name: str) -> tuple[Doubles, Doubles, Doubles]:
        group = frame.groups[name]
        assert group.velocities is not None
        return (
            group.positions.astype(np.float64),
            group.velocities.astype(np.float64),
            masses(self._plans[name], group.ids),
        )

    def _note(self, name: str, value: Doubles, scale: float) -> None:
        if name in self._values:
            self._values[name].append(value)
            self._scales[name] = max(self._scales[name], float(scale))


def _kept(simulation: Simulation) -> list[str]:
    """What the forces and planes of a scene conserve."""
    plans, couplings = simulation.plan.groups, simulation.plan.couplings
    forces: list[Force] = [coupling.force for coupling in couplings]
    if not plans or not all(map(_stays, plans)) or not all(map(_pairwise, forces)):
        return []
    pinned = any(plan.pins for plan in plans)
    free = not pinned and not any(plan.forces or plan.planes for plan in plans)
    boxed = any(isinstance(force, LennardJones) and force.periodic for force in forces)
    groups = [simulation.system.groups[plan.name] for plan in plans]
    alone = all(conserves_energy(group) or not (group.plan.forces or group.plan.planes) for group in groups)
    kept = {
        "energy": not pinned and alone and all(map(_lossless, forces)),
        "momentum": free,
        "angular momentum": free and not boxed,
    }
    return [name for name, holds in kept.items() if holds]


def _stays(plan: GroupPlan) -> bool:
    """Whether a group acts as one with others and has the same particles at all times."""
    particles = isinstance(plan.births, ParticleBirths) and not {"lifetime", "fate"} & set(plan.components)
    return plan.coupled and particles


def _pairwise(force: Force) -> bool:
    """Whether a force acts along the line between two particles, on both alike."""
    return isinstance(force, Attraction | Springs | LennardJones)


def _lossless(force: Force) -> bool:
    """Whether a force between particles has a potential that stays as it is."""
    if isinstance(force, Springs):
        return force.damping == 0.0 and force.breaks_at is None and "t" not in force.rest_length.names
    return True

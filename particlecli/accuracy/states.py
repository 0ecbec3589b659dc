"""States of particles of a group: as they are born, or as they are in a simulation now."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.birth_table import BirthTable
from particlecli.dynamics.group_plan import Constant, GroupPlan
from particlecli.dynamics.sampling import spread

if TYPE_CHECKING:
    from particlecli.dynamics.system import System

Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class States:
    """States of n particles.

    Attributes:
        ids: numbers of the particles, shape (n,).
        times: s, shape (n,).
        motion: position, m, and velocity, m/s, shape (6, n); positions alone in a first-order group, (3, n).
        inverse_masses: 1/kg, shape (n,).
        total: how many particles these stand for.
    """

    ids: NDArray[np.int64]
    times: Doubles
    motion: Doubles
    inverse_masses: Doubles
    total: int

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def names(self) -> dict[str, Doubles]:
        """The components and the time, each of shape (n,), by what expressions of the scene call them."""
        return {"t": self.times, **dict(zip("xyzuvw", self.motion, strict=False))}

    def at(self, places: NDArray[np.bool_]) -> States:
        """Some of them."""
        return States(
            self.ids[places],
            self.times[places],
            self.motion[:, places],
            self.inverse_masses[places],
            self.total,
        )


def states_at_birth(group: GroupPlan, most: int) -> States:
    """Up to `most` particles of a group as they are born, spread evenly over its births."""
    table = group.births.of(spread(group.births.total, most))
    motion = table.positions if table.velocities is None else np.vstack([table.positions, table.velocities])
    masses = _inverse_masses(group, table)
    return States(table.ids, table.times, motion.astype(float), masses, group.births.total)


def states_now(system: System, group: GroupPlan, most: int) -> States:
    """Up to `most` of the particles of a group that are alive in a system, spread evenly over them."""
    frame = system.frame(0).groups[group.name]
    places = spread(len(frame.ids), most)
    parts = [frame.positions] if frame.velocities is None else [frame.positions, frame.velocities]
    motion = np.vstack([part[places].T for part in parts]).astype(float)
    ids, times = frame.ids[places], np.full(len(places), system.time)
    return States(ids, times, motion, _inverse_masses(group, group.births.of(ids)), len(frame.ids))


def _inverse_masses(group: GroupPlan, table: BirthTable) -> Doubles:
    if table.masses is None:
        return np.full(len(table), group.constants[Constant.INVERSE_MASS])
    return np.asarray(1.0 / table.masses)

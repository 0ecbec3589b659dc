"""From what particles are born with to the components of their state."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.birth_table import BirthTable


def columns_of(table: BirthTable, time: float) -> dict[str, NDArray[Any]]:
    """The state of newborn particles at a time in s, component by component, each of shape (n,).

    Before its birth an age is negative.
    """
    count = len(table)
    columns = {"id": table.ids, "age": time - table.times}
    columns |= {name: np.zeros(count) for name in ("fate", "pace", "impacts")}
    columns |= dict(zip("xyz", table.positions, strict=True))
    if table.velocities is not None:
        columns |= dict(zip("uvw", table.velocities, strict=True))
    return columns | {name: values for name, values in _properties(table).items() if values is not None}


def _properties(table: BirthTable) -> dict[str, NDArray[np.float64] | None]:
    return {
        "lifetime": table.lifetimes,
        "temperature": table.temperatures,
        "cooling_rate": table.cooling_rates,
        "inverse_mass": None if table.masses is None else 1.0 / table.masses,
    }

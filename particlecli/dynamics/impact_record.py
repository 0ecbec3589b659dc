"""What impacts bear: where and when each particle struck a plane, for as many impacts as bear children."""

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli.dynamics.group_plan import LANES
from particlecli.dynamics.memory import FieldMemory
from particlecli.dynamics.state import PackedState

COLUMNS = 7
"""Time, position and velocity after the impact."""


@ti.data_oriented
class ImpactRecord:
    """The first impacts of each particle of a group, written by its kernel; it counts them in the group's state.

    Args:
        state: of the group, with a component "impacts".
        most: how many impacts of each particle are kept.
        real: type of its numbers.
        memory: of the system.
    """

    def __init__(self, state: PackedState, most: int, real, memory: FieldMemory) -> None:
        self.state = state
        self.most = most
        self.rows = ti.field(real, shape=(state.capacity, most, COLUMNS))
        self._view = memory.view(self.rows)

    @ti.func
    def write(self, slot, t, state):
        """Note an impact of the particle in a slot at time t, with its state after it."""
        row, b, lane = ti.static(self.state.row("impacts")), slot // LANES, slot % LANES
        number = self.state.integers[row, b][lane]
        if number < self.most:
            self.rows[slot, number, 0] = t
            for c in ti.static(range(6)):
                self.rows[slot, number, c + 1] = state[c]
            self.state.integers[row, b][lane] = number + 1

    def read(self, slots: NDArray[np.int64], numbers: NDArray[np.int64]) -> NDArray[np.float64]:
        """Impacts by slot and by number, shape (7, n): time in s, position in m, velocity in m/s."""
        return self._view.array[slots, numbers].T.astype(np.float64)

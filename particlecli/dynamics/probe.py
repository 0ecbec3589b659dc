"""The equations of motion and the energy of a group at states and times of one's own choosing."""

from itertools import accumulate

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli import runtime
from particlecli.dynamics.algebra import bound
from particlecli.dynamics.memory import FieldMemory
from particlecli.dynamics.motion import Motion
from particlecli.runtime import Precision

Doubles = NDArray[np.float64]

Column = ti.types.ndarray(dtype=ti.f64, ndim=1)
Table = ti.types.ndarray(dtype=ti.f64, ndim=2)
Tables = ti.types.ndarray(dtype=ti.f64, ndim=3)
Matrices = ti.types.ndarray(dtype=ti.f64, ndim=4)
Counts = ti.types.ndarray(dtype=ti.i32, ndim=1)
"""Arrays that kernels take."""

IDLE = 6
"""Components that motion is given; a first-order group does not look at the last three."""


@ti.data_oriented
class Probe:
    """Evaluates a group's motion particle by particle, each at its own time, apart from the group's state.

    Args:
        motion: the equations of motion, the tables of its flows filled in.
        precision: of the numbers to compute with, the one the runtime was started with.
    """

    def __init__(self, motion: Motion, precision: Precision) -> None:
        runtime.use(self)
        self.motion = motion
        self.real = ti.f64 if precision == "double" else ti.f32
        self.components = 3 if motion.first_order else 6
        lists = [list(term.parameters()) for term in motion.terms()]
        ends = list(accumulate(len(values) for values in lists))
        self.spans = [(end - len(values), end) for end, values in zip(ends, lists, strict=True)]
        numbers = np.array([number for values in lists for number in values] or [0.0])
        memory = FieldMemory()
        self.table = memory.table(self.real, numbers)
        memory.open()

    def derivative(self, states: Doubles, times: Doubles, inverse_masses: Doubles) -> Doubles:
        """Time derivatives of the states.

        Args:
            states: shape (6, n), or (3, n) for a first-order group: position, m, and velocity, m/s.
            times: shape (n,), s.
            inverse_masses: shape (n,), 1/kg.

        Returns:
            As `states`: velocity and acceleration, or the velocity of what carries the group.
        """
        slopes = np.empty(states.shape)
        if slopes.size:
            self._differentiate(np.ascontiguousarray(states), times, inverse_masses, slopes)
        return slopes

    def potential(self, states: Doubles, times: Doubles, inverse_masses: Doubles) -> Doubles:
        """Potential energy by mass, J/kg, shape (n,); forces that have none do not count. As `derivative`."""
        energies = np.zeros(states.shape[1])
        if energies.size:
            self._weigh(np.ascontiguousarray(states), times, inverse_masses, energies)
        return energies

    def jacobian(self, states: Doubles, times: Doubles, inverse_masses: Doubles) -> Doubles:
        """The matrices ∂a/∂x, 1/s², and ∂a/∂v, 1/s; of a first-order group ∂u/∂x and zero. As `derivative`.

        Returns:
            Shape (2, n, 3, 3); rows are components of the acceleration.
        """
        matrices = np.zeros((2, states.shape[1], 3, 3))
        if matrices.size:
            self._linearize(np.ascontiguousarray(states), times, inverse_masses, matrices)
        return matrices

    @ti.func
    def _loaded(self):
        return [
            [bound(self.table[i]) for i in ti.static(range(self.spans[j][0], self.spans[j][1]))]
            for j in ti.static(range(len(self.spans)))
        ]

    @ti.func
    def _state(self, states: ti.template(), i):
        return [ti.cast(states[c if c < self.components else 0, i], self.real) for c in ti.static(range(IDLE))]

    @ti.kernel
    def _differentiate(self, states: Table, times: Column, inverse_masses: Column, out: Table):
        for i in range(states.shape[1]):
            p = self._loaded()
            state = self._state(states, i)
            time, inverse_mass = ti.cast(times[i], self.real), ti.cast(inverse_masses[i], self.real)
            slopes = self.motion.derivative(p, state, time, [inverse_mass])
            for c in ti.static(range(self.components)):
                out[c, i] = slopes[c]

    @ti.kernel
    def _weigh(self, states: Table, times: Column, inverse_masses: Column, out: Column):
        for i in range(states.shape[1]):
            p = self._loaded()
            state = self._state(states, i)
            time, inverse_mass = ti.cast(times[i], self.real), ti.cast(inverse_masses[i], self.real)
            for j in ti.static(range(len(self.motion.forces))):
                if ti.static(self.motion.forces[j].has_potential):
                    q = p[self.motion.firsts[-1] + j]
                    out[i] = out[i] + self.motion.forces[j].potential(q, state[:3], time, inverse_mass)

    @ti.kernel
    def _linearize(self, states: Table, times: Column, inverse_masses: Column, out: Matrices):
        for i in range(states.shape[1]):
            p = self._loaded()
            state = self._state(states, i)
            time, inverse_mass = ti.cast(times[i], self.real), ti.cast(inverse_masses[i], self.real)
            matrices = self.motion.jacobian(p, state, time, [inverse_mass])
            for k, row, column in ti.static(ti.ndrange(2, 3, 3)):
                out[k, i, row, column] = matrices[k][row][column]

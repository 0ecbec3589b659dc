"""Steps of implicit schemes on a sample of particles, in NumPy: pilots are to compile nothing but the forces."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.integrators.base import ImplicitRungeKutta

Doubles = NDArray[np.float64]


class Sampled(NamedTuple):
    """Particles at instants of their own.

    Attributes:
        states: position, m, and velocity, m/s, shape (6, n), or positions alone, (3, n).
        times: s, shape (n,).
        weights: inverse masses, 1/kg, shape (n,).
    """

    states: Doubles
    times: Doubles
    weights: Doubles

    def at(self, places: NDArray[np.int64]) -> Sampled:
        """Some of them."""
        return Sampled(self.states[:, places], self.times[places], self.weights[places])


class Motion(NamedTuple):
    """The equations of motion.

    Attributes:
        slopes: time derivatives of the states, in their shape.
        jacobian: ∂a/∂x and ∂a/∂v, or ∂u/∂x and zero, shape (2, n, 3, 3).
    """

    slopes: Callable[[Doubles, Doubles, Doubles], Doubles]
    jacobian: Callable[[Doubles, Doubles, Doubles], Doubles]


Step = Callable[[Sampled, Doubles], Doubles]
"""The states after a step of each particle's own length, s, shape (n,)."""

NEWTON = 4
"""Newton iterations of an implicit step."""


def implicit_step(scheme: ImplicitRungeKutta, motion: Motion, sample: Sampled, h: Doubles) -> Doubles:
    """The states after a step of each particle's own length, s, shape (n,).

    By Newton's method with the Jacobian of the beginning, for the stages' slopes k_i = f(y + h Σ a_ij k_j).
    """
    size, count = sample.states.shape
    stages = len(scheme.b)
    a = np.array(scheme.a)
    jacobian = _full_jacobian(motion, sample)
    matrix = np.eye(stages * size) - np.einsum("n,ij,nkl->nikjl", h, a, jacobian).reshape(
        count, stages * size, stages * size
    )
    start = motion.slopes(sample.states, sample.times, sample.weights)
    slopes = [start.copy() for _ in range(stages)]
    for _ in range(NEWTON):
        residual = np.stack(
            [
                motion.slopes(sample.states + h * _weighted(row, slopes), sample.times + c * h, sample.weights) - k
                for row, c, k in zip(scheme.a, scheme.c, slopes, strict=True)
            ]
        )
        change = np.linalg.solve(matrix, residual.transpose(2, 0, 1).reshape(count, -1, 1))
        for i, part in enumerate(change.reshape(count, stages, size).transpose(1, 2, 0)):
            slopes[i] = slopes[i] + part
    return sample.states + h * _weighted(scheme.b, slopes)


def _full_jacobian(motion: Motion, sample: Sampled) -> Doubles:
    """Of the slopes by the states, shape (n, d, d)."""
    by_position, by_velocity = motion.jacobian(sample.states, sample.times, sample.weights)
    if len(sample.states) == 3:
        return np.asarray(by_position)
    full = np.zeros((len(sample.times), 6, 6))
    full[:, :3, 3:] = np.eye(3)
    full[:, 3:, :3], full[:, 3:, 3:] = by_position, by_velocity
    return full


def _weighted(weights: tuple[float, ...], slopes: list[Doubles]) -> Doubles | float:
    return sum((weight * slope for weight, slope in zip(weights, slopes, strict=False) if weight), start=0.0)

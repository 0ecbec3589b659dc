"""Particles that fly apart from each other, each at its own time, and their exact flight by SciPy."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import OdeSolution, solve_ivp

from particlecli.errors import ParticleError

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]

RELATIVE_TOLERANCE = 1e-12
ABSOLUTE_TOLERANCE = 1e-14
"""Of a step of DOP853, m and m/s."""

FREE, STUCK = -1, -2


class CannotJudgeError(ParticleError):
    """The independent judge cannot follow this scene; the message says why."""

    exit_code = 2


@dataclass
class Bodies:
    """Some particles of a group; the last axis of every array counts them.

    Attributes:
        ids: their numbers.
        states: x, y, z[, u, v, w], m and m/s, shape (3 or 6, n).
        times: when each is there, s.
        inverse_masses: 1/kg.
        on: the plane each rests or slides on, FREE or STUCK.
        held: whether friction holds it there.
        forward: unit vector along which it slides, shape (3, n).
        reach: largest coordinate at the beginning of the frame, m, from which rounding comes.
    """

    ids: NDArray[np.int64]
    states: Doubles
    times: Doubles
    inverse_masses: Doubles
    on: NDArray[np.int64]
    held: Mask
    forward: Doubles
    reach: Doubles

    @classmethod
    def born(cls, ids: NDArray[np.int64], states: Doubles, times: Doubles, inverse_masses: Doubles) -> Bodies:
        """Particles that touch nothing yet."""
        n = len(ids)
        free = np.full(n, FREE)
        reach = np.abs(states[:3]).max(axis=0)
        return cls(ids, states, times, inverse_masses, free, np.zeros(n, bool), np.zeros((3, n)), reach)

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def x(self) -> Doubles:
        """Positions, m, shape (3, n)."""
        return self.states[:3]

    @property
    def v(self) -> Doubles:
        """Velocities, m/s, shape (3, n); of a first-order group there are none."""
        return self.states[3:]

    def copy(self) -> Bodies:
        """The same, apart."""
        return Bodies(*(getattr(self, field.name).copy() for field in fields(self)))

    def rows(self, which: Mask | NDArray[np.int64]) -> Bodies:
        """A copy of some of them."""
        return Bodies(*(getattr(self, field.name)[..., which].copy() for field in fields(self)))

    def put(self, which: Mask | NDArray[np.int64], others: Bodies) -> None:
        """Replace some of them."""
        for field in fields(self):
            getattr(self, field.name)[..., which] = getattr(others, field.name)

    def at(self, states: Doubles, times: Doubles) -> Bodies:
        """The same particles in other states."""
        return replace(self, states=states, times=times)

    def joined(self, others: Bodies) -> Bodies:
        """Both, these first."""
        pairs = ((getattr(self, field.name), getattr(others, field.name)) for field in fields(self))
        return Bodies(*(np.concatenate(pair, axis=-1) for pair in pairs))


Slopes = Callable[[Bodies], Doubles]
"""Time derivatives of the states of bodies."""


def flight(bodies: Bodies, ends: Doubles, slopes: Slopes) -> OdeSolution:
    """Integrate every body from its own time to its own end, s, by DOP853.

    Bodies do not act on each other, so one integration over s from 0 to 1 serves them all: body i is there at
    the time t_i + s (end_i − t_i).

    Returns:
        A function of s with the states, components one after the other, shape (components · n,) or, for an
        array of s, (components · n, len(s)); its `ts` are the steps that were taken.

    Raises:
        CannotJudgeError: the motion cannot be integrated to this accuracy.
    """
    spans = ends - bodies.times

    def rate(s: float, flat: Doubles) -> Doubles:
        states = flat.reshape(bodies.states.shape)
        return (spans * slopes(bodies.at(states, bodies.times + s * spans))).ravel()

    # SciPy bounds the mean square over all components; here each single one shall be right.
    share = RELATIVE_TOLERANCE / math.sqrt(max(1, bodies.states.size))
    outcome = solve_ivp(
        rate,
        (0.0, 1.0),
        bodies.states.flatten(),  # a copy: the solution keeps it
        method="DOP853",
        rtol=max(share, 3e-14),
        atol=ABSOLUTE_TOLERANCE,
        dense_output=True,
    )
    if not outcome.success or outcome.sol is None or not np.isfinite(outcome.y[:, -1]).all():
        raise CannotJudgeError(
            f"SciPy cannot integrate the motion after t = {bodies.times.min():.6g} s: {outcome.message}"
        )
    return outcome.sol

"""Rates of birth, their integrals over time and when these integrals reach given values.

Nothing here knows of steps or frames: a varying rate is integrated over a partition of its own.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from particlecli.dynamics.random import Array
from particlecli.errors import SimulationError
from particlecli.scene.expression import Expression

CELLS = 4096
"""A varying rate is first cut into at least so many cells, whose width is a power of two."""

MOST_CELLS = 2**18
"""Cells are no longer halved when there are so many: the rate oscillates faster than births can follow."""

MOST_HALVINGS = 48
TOLERANCE = 1e-14
"""A cell is halved as long as its integral is uncertain by more than this share of the whole."""

CONVERGED = 1e-12
"""Instants are found to this share of a cell."""

MOST_NEWTON_STEPS = 100

NODES = np.array([0.0, 0.5 - math.sqrt(3 / 28), 0.5, 0.5 + math.sqrt(3 / 28), 1.0])
"""Gauss–Lobatto nodes of a cell: with its ends among them no jump can hide in a cell."""

DEGREE = len(NODES)
INTEGRATION = np.linalg.inv(np.vander(NODES, increasing=True)) / np.arange(1, DEGREE + 1)[:, None]
"""From values at the nodes to the coefficients of u, u², … in the integral from 0 to u."""


class Rate(Protocol):
    """Births a second over a span of time."""

    total: float

    def integral(self, times: Array) -> Array:
        """Shape (n,): ∫ rate dt from the start to each time."""
        ...

    def instants(self, targets: Array) -> Array:
        """Shape (n,), s: when the integral reaches each target, none of which is above `total`."""
        ...


class ConstantRate:
    """The same rate from start to stop.

    Attributes:
        total: the integral over the whole time.
    """

    def __init__(self, rate: float, start: float, stop: float) -> None:
        self._rate, self._start, self._stop = rate, start, stop
        self.total = rate * (stop - start)

    def integral(self, times: Array) -> Array:
        """Shape (n,): ∫ rate dt from the start to each time."""
        elapsed: Array = np.clip(times, self._start, self._stop) - self._start
        return self._rate * elapsed

    def instants(self, targets: Array) -> Array:
        """Shape (n,), s: when the integral reaches each target, none of which is above `total`."""
        return np.minimum(self._start + targets / self._rate, self._stop)


class VaryingRate:
    """A rate that is an expression of t, counted as zero where it is negative.

    It is a polynomial of degree 4 in each cell of a partition that is refined until halving a cell changes
    nothing; so jumps and kinks are found too. Where it is too wild for that, its mean stands in.

    Attributes:
        total: the integral over the whole time.

    Raises:
        SimulationError: the rate is not finite at some time.
    """

    def __init__(self, rate: Expression, start: float, stop: float) -> None:
        self._rate, self._stop = rate, stop
        self._partition(_edges(start, stop))
        ends = np.cumsum(self._coefficients.sum(axis=0))
        self._before = np.concatenate(([0.0], ends))
        self.total = float(ends[-1])

    def integral(self, times: Array) -> Array:
        """Shape (n,): ∫ rate dt from the start to each time."""
        cells = np.clip(np.searchsorted(self._low, times, side="right") - 1, 0, None)
        share = np.clip((times - self._low[cells]) / self._width[cells], 0.0, 1.0)
        return self._before[cells] + _integral(self._coefficients[:, cells], share)

    def instants(self, targets: Array) -> Array:
        """Shape (n,), s: when the integral reaches each target, none of which is above `total`."""
        cells = np.clip(np.searchsorted(self._before, targets) - 1, 0, len(self._low) - 1)
        share = _solve(self._coefficients[:, cells], targets - self._before[cells])
        return np.minimum(self._low[cells] + share * self._width[cells], self._stop)

    def _values(self, low: Array, width: Array) -> Array:
        """Shape (nodes, cells): the rate at the nodes."""
        times = np.minimum(low + NODES[:, None] * width, self._stop)
        with np.errstate(all="ignore"):
            values = np.broadcast_to(np.asarray(self._rate.evaluate({"t": times}), np.float64), times.shape)
        wrong = ~np.isfinite(values)
        if wrong.any():
            place = np.argmin(np.where(wrong, times, np.inf))
            raise SimulationError(
                f"the rate `{self._rate.source}` is {values.flat[place]} at t = {times.flat[place]:.6g} s"
            )
        return np.maximum(values, 0.0)

    def _partition(self, edges: Array) -> None:
        low, width = edges[:-1], np.diff(edges)
        coefficients = _coefficients(self._values(low, width), width)
        tolerance = TOLERANCE * coefficients.sum()
        done: list[tuple[Array, Array, Array]] = []
        for halving in range(MOST_HALVINGS + 1):
            half = width / 2
            left = _coefficients(self._values(low, half), half)
            right = _coefficients(self._values(low + half, half), half)
            to_middle, whole = _integral(coefficients, np.full_like(low, 0.5)), coefficients.sum(axis=0)
            error = np.maximum(
                np.abs(left.sum(axis=0) - to_middle), np.abs(left.sum(axis=0) + right.sum(axis=0) - whole)
            )
            fine = error <= tolerance
            if halving == MOST_HALVINGS or len(low) > MOST_CELLS:
                coefficients[:, ~fine] = np.where(np.arange(DEGREE)[:, None] == 0, whole[~fine], 0.0)
                fine[:] = True
            done.append((low[fine], width[fine], coefficients[:, fine]))
            if fine.all():
                break
            low, width, half = low[~fine], width[~fine], half[~fine]
            coefficients = np.concatenate((left[:, ~fine], right[:, ~fine]), axis=1)
            low, width = np.concatenate((low, low + half)), np.concatenate((half, half))
        low, width, coefficients = (np.concatenate(parts, axis=-1) for parts in zip(*done, strict=True))
        order = np.argsort(low)
        self._low, self._width, self._coefficients = low[order], width[order], coefficients[:, order]


def _edges(start: float, stop: float) -> Array:
    """Cells whose width is a power of two: another stop then seldom moves them, nor births by rounding."""
    width = 2.0 ** math.floor(math.log2((stop - start) / CELLS))
    return np.append(start + width * np.arange(math.ceil((stop - start) / width)), stop)


def _coefficients(values: Array, width: Array) -> Array:
    # Not a matrix product: BLAS may round a column differently when others stand beside it.
    result: Array = np.zeros_like(values)
    for column, value in zip(INTEGRATION.T, values, strict=True):
        result += column[:, None] * value
    return result * width


def _integral(coefficients: Array, share: Array) -> Array:
    """The polynomial Σ c_m u^(m+1)."""
    value: Array = np.zeros_like(share)
    for power in range(DEGREE, 0, -1):
        value = (value + coefficients[power - 1]) * share
    return value


def _slope(coefficients: Array, share: Array) -> Array:
    value: Array = np.zeros_like(share)
    for power in range(DEGREE, 0, -1):
        value = value * share + power * coefficients[power - 1]
    return value


def _solve(coefficients: Array, targets: Array) -> Array:
    """Where in (0, 1) the integral of a cell reaches a target: Newton, or bisection where that leaps too far.

    Each one stops when it has converged, so that it does not depend on which others are asked for with it.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        result = np.clip(np.nan_to_num(targets / _integral(coefficients, np.ones_like(targets))), 0.0, 1.0)
        low, high = np.zeros_like(result), np.ones_like(result)
        active = np.arange(len(result))
        for _ in range(MOST_NEWTON_STEPS):
            share, formulas = result[active], coefficients[:, active]
            excess = _integral(formulas, share) - targets[active]
            low[active] = np.where(excess < 0, share, low[active])
            high[active] = np.where(excess >= 0, share, high[active])
            newton = share - excess / _slope(formulas, share)
            inside = (newton >= low[active]) & (newton <= high[active])
            result[active] = np.where(inside, newton, (low[active] + high[active]) / 2)
            active = active[np.abs(result[active] - share) > CONVERGED]
            if not len(active):
                break
    return result

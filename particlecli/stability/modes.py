"""Modes of motion: the eigenvalues of linearized equations of motion, and what kind of motion each is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Doubles = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Places = NDArray[np.intp] | NDArray[np.bool_] | slice

Kind = Literal["free", "oscillation", "decay", "growth"]

ROUNDING = 1e-7
"""Rates below this part of the fastest that the Jacobian admits are taken for zero."""

STRAY = 1e-5
"""Real or imaginary parts below this part of the whole are taken for zero."""

ALL_ROUND = 13
"""Directions in the left half plane, and sizes, by which those stand for all that are no faster."""

ALIKE = 0.03
"""Modes are alike whose rates, in parts of their size, differ by less than this."""

GROWING = 0.01
"""A mode grows by itself where Re α is more than this part of |α|; no step can make it stable."""


@dataclass(frozen=True)
class Modes:
    """Modes e^(αt) of linear motion, each with the oscillator ẍ = −κx − dẋ that it belongs to.

    Attributes, arrays of one shape:
        rates: α, 1/s.
        stiffness: κ, 1/s².
        damping: d, 1/s; a mode of first-order motion ẋ = αx has κ = 0 and d = −α.
    """

    rates: Complexes
    stiffness: Complexes
    damping: Complexes

    @classmethod
    def of_pairs(cls, rates: Complexes) -> Modes:
        """Modes that share an oscillator with their complex conjugates, a real one with its like."""
        return cls(rates, (np.abs(rates) ** 2).astype(complex), (-2.0 * rates.real).astype(complex))

    @classmethod
    def of_first_order(cls, rates: Complexes) -> Modes:
        """Modes of ẋ = αx, or of a velocity that a drag slows down."""
        return cls(rates, np.zeros_like(rates), -rates)

    @classmethod
    def around(cls, rate: float, *, turning: bool) -> Modes:
        """Oscillations and decays of all kinds with rates up to one of which only the size, 1/s, is known.

        Args:
            rate: the size, 1/s.
            turning: whether there are also forces that turn velocities, as a magnetic field does.
        """
        angles = np.linspace(0.5 * np.pi, np.pi, ALL_ROUND)
        rates = (rate * np.linspace(1.0, 0.1, ALL_ROUND)[:, None] * np.exp(1j * angles)).ravel()
        slowing = rates if turning else rates.real[np.abs(rates.imag) < STRAY * rate].astype(complex)
        return cls.of_pairs(rates).joined(cls.of_first_order(slowing))

    def at(self, places: Places) -> Modes:
        """Those at given places."""
        return Modes(self.rates[places], self.stiffness[places], self.damping[places])

    def shaped(self, *shape: int) -> Modes:
        """The same ones in another shape."""
        return Modes(self.rates.reshape(shape), self.stiffness.reshape(shape), self.damping.reshape(shape))

    def joined(self, other: Modes) -> Modes:
        """These and others, in a row."""
        return Modes(
            np.concatenate([self.rates, other.rates]),
            np.concatenate([self.stiffness, other.stiffness]),
            np.concatenate([self.damping, other.damping]),
        )

    def distinct(self, *, paired: bool) -> Modes:
        """The fastest of those that are alike but for their pace; of complex conjugates one; none that rests.

        What is stable for these is stable for all, nearly.

        Args:
            paired: whether their oscillators must be alike, too.
        """
        real = (self.stiffness.imag == 0.0) & (self.damping.imag == 0.0)
        modes = self.at((self.rates != 0.0) & ~(real & (self.rates.imag < 0.0)))
        modes = modes.at(np.argsort(-np.abs(modes.rates), kind="stable"))
        size = np.abs(modes.rates)
        shapes = [modes.rates / size, *([modes.damping / size] if paired else [])]
        parts = np.array([part for shape in shapes for part in (shape.real, shape.imag)])
        _, places = np.unique(np.round(parts / ALIKE), axis=1, return_index=True)
        return modes.at(np.sort(places))

    @property
    def partners(self) -> Complexes:
        """The other rate of each mode's oscillator, 1/s."""
        return -self.damping - self.rates

    @property
    def counting(self) -> NDArray[np.bool_]:
        """Which of them a step must not let grow: those that oscillate or decay."""
        size = np.abs(self.rates)
        return (size > 0.0) & (self.rates.real <= GROWING * size)


def modes_of(by_position: Doubles, by_velocity: Doubles | None = None, rounding: float = ROUNDING) -> Modes:
    """The modes of ẍ = Jx + Gẋ, the eigenvalues of [[0, I], [J, G]]; or of ẋ = Jx.

    An eigenvector e of position gives the mode's oscillator by κ = −e*Je and d = −e*Ge with |e| = 1, so that
    α² + dα + κ = 0. Where J and G have e in common, kicks and drifts do not leave that oscillator.

    Args:
        by_position: J = ∂a/∂x of n particles, 1/s², shape (n, 3, 3); ∂u/∂x, 1/s, in first order. Or of n systems
            of c coordinates, shape (n, c, c).
        by_velocity: G = ∂a/∂v, 1/s, of the same shape; none in first order.
        rounding: part of the fastest rate that the matrices admit, below which rates are taken for zero.

    Returns:
        Modes of shape (n, 2 c), or (n, c) in first order.
    """
    if by_velocity is None:
        size = _or_one(_norm(by_position))
        rates = np.linalg.eigvals(by_position).astype(complex)
        return Modes.of_first_order(cleaned(rates, rounding * size))
    size = _or_one(np.maximum(np.sqrt(_norm(by_position)), _norm(by_velocity)))
    J, G = by_position / size[..., None] ** 2, by_velocity / size[..., None]
    coordinates = J.shape[-1]
    velocity = np.broadcast_to(np.eye(coordinates), J.shape)
    rates, vectors = np.linalg.eig(np.block([[np.zeros_like(J), velocity], [J, G]]))
    e = vectors[:, :coordinates] / np.linalg.norm(vectors[:, :coordinates], axis=1, keepdims=True)
    stiffness, damping = (-np.einsum("nim,nij,njm->nm", e.conj(), matrix, e).astype(complex) for matrix in (J, G))
    return Modes(
        cleaned(rates.astype(complex), rounding) * size,
        cleaned(stiffness, 0.0) * size**2,
        cleaned(damping, STRAY * np.sqrt(np.abs(stiffness))) * size,
    )


def _norm(matrices: Doubles) -> Doubles:
    """Of each of n matrices, shape (n, 1)."""
    return np.asarray(np.linalg.norm(matrices, axis=(1, 2)))[:, None]


def _or_one(size: Doubles) -> Doubles:
    return np.where(size > 0.0, size, 1.0)


def cleaned(numbers: Complexes, least: Doubles | float) -> Complexes:
    """The numbers without stray real or imaginary parts; zero where they are less than the least."""
    size = np.abs(numbers)
    real = np.where(np.abs(numbers.real) < STRAY * size, 0.0, numbers.real)
    imaginary = np.where(np.abs(numbers.imag) < STRAY * size, 0.0, numbers.imag)
    return np.where(size < least, 0.0, real + 1j * imaginary)


def kinds_of(rates: Complexes) -> NDArray[np.str_]:
    """What `Kind` of motion each mode is; a damped oscillation counts as what it does first."""
    sinking = np.where(np.abs(rates.imag) > -rates.real, "oscillation", "decay")
    moving = np.where(rates.real > GROWING * np.abs(rates), "growth", sinking)
    return np.where(rates == 0.0, "free", moving)


def describe(rate: complex) -> str:
    """A mode in words."""
    kind = str(kinds_of(np.array(rate)))
    match kind:
        case "oscillation":
            return f"an oscillation of {abs(rate.imag) / math.tau:.3g} Hz"
        case "free":
            return "a free motion"
        case _:
            return f"a {kind} at {abs(rate.real):.3g} 1/s"

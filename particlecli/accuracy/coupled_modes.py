"""The modes of particles that act on each other, all of them together."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs

from particlecli.accuracy.coupled_motion import CoupledMotion
from particlecli.stability.modes import STRAY, Complexes, Doubles, Modes, cleaned, modes_of

DENSE = 480
"""Up to so many coordinates the Jacobians are put together, and all modes computed."""

ROUNDING = 1e-5
"""Rates below this part of the fastest are taken for zero: differences do not tell them from that."""

EXTREMES, VECTORS = 4, 30
"""Modes at an end of the spectrum that are looked for, in a Krylov space of so many vectors."""

RESIDUAL = 1e-2
"""What eigenvectors may be wrong by, in parts of their eigenvalue, which is far more exact where they are
orthogonal."""

WIDTH = 3e-3
"""Growth is seen where the square of its rate is more than this part of the largest |∂a/∂x|."""

RESTARTS = 25
"""Of ARPACK; what has not converged by then is left out."""

ALIKE = 1e-2
"""Rates of two searches that differ by less, in parts of them, are the same mode."""


@dataclass(frozen=True)
class Spectrum:
    """The modes of coupled particles.

    Attributes:
        modes: all of them, shape (2 size,), or the fastest of each kind.
        complete: whether these are all.
        position_rate, velocity_rate: the square root of the largest |∂a/∂x|, and the largest |∂a/∂v|, 1/s.
    """

    modes: Modes
    complete: bool
    position_rate: float
    velocity_rate: float


def spectrum(motion: CoupledMotion) -> Spectrum:
    """The modes of a motion about its state: all where coordinates are few, else the extremes by ARPACK."""
    return _dense(motion) if motion.size <= DENSE else _sparse(motion)


def _dense(motion: CoupledMotion) -> Spectrum:
    J = motion.by_position()
    G = motion.by_velocity() if motion.damped else np.zeros_like(J)
    if motion.damped:
        modes = modes_of(J[None], G[None], ROUNDING).shaped(-1)
    else:
        modes = _undamped(np.linalg.eigvals(J).astype(complex), float(np.linalg.norm(J)))
    sizes = [float(np.linalg.norm(matrix, 2)) if len(matrix) else 0.0 for matrix in (J, G)]
    return Spectrum(modes, True, math.sqrt(sizes[0]), sizes[1])


def _undamped(squares: Complexes, largest: float) -> Modes:
    """The modes of ẍ = Jx, whose rates are the roots of the eigenvalues of J."""
    squares = cleaned(squares, ROUNDING**2 * largest)
    rates = cleaned(np.sqrt(squares), 0.0)
    return Modes(np.concatenate([rates, -rates]), np.tile(-squares, 2), np.zeros(2 * len(rates), complex))


def _sparse(motion: CoupledMotion) -> Spectrum:
    rest = np.zeros(motion.size)

    def pull(y: Doubles) -> Doubles:
        return motion.along(y, rest)

    back = _extremes(pull, motion.size, "SR")[0]
    width = float(np.abs(back).max(initial=0.0))
    away = _extremes(lambda y: width * y + pull(y), motion.size, "LR")[0] - width
    squares = np.concatenate([back, away[away.real > WIDTH * width]])
    position_rate = math.sqrt(float(np.abs(squares).max(initial=0.0)))
    if not motion.damped:
        return Spectrum(_undamped(squares, position_rate**2), False, position_rate, 0.0)
    damping = _extremes(lambda w: motion.along(rest, w), motion.size, "LM")[0]
    velocity_rate = float(np.abs(damping).max(initial=0.0))
    modes = _damped(motion, max(position_rate, velocity_rate) or 1.0, grows=len(squares) > len(back))
    return Spectrum(modes, False, position_rate, velocity_rate)


def _damped(motion: CoupledMotion, scale: float, *, grows: bool) -> Modes:
    """Modes at ends of the spectrum of [[0, I], [J, G]], positions being measured in 1/scale, s."""
    size = motion.size

    def slopes(state: Doubles) -> Doubles:
        position, velocity = state[:size] / scale, state[size:]
        return np.concatenate([velocity, motion.along(position, velocity) / scale])

    found: list[tuple[complex, complex, complex]] = []

    def search(end: str, shift: float = 0.0) -> None:
        rates, vectors = _extremes(lambda y: shift * y + slopes(y) if shift else slopes(y), 2 * size, end)
        for rate, vector in zip(scale * (rates - shift), vectors.T, strict=True):
            if all(abs(rate - known) > ALIKE * abs(known) for known, _, _ in found):
                e = vector[:size] / np.linalg.norm(vector[:size])
                found.append((rate, *_oscillator(motion, e)))

    search("LM")
    if all(abs(rate.imag) < STRAY * abs(rate) for rate, _, _ in found):
        search("LI")
    if grows:
        search("LR", shift=1.0)
    rates, stiffness, damping = np.array(found, complex).reshape(-1, 3).T
    return Modes(
        cleaned(rates, ROUNDING * scale),
        cleaned(stiffness, 0.0),
        cleaned(damping, STRAY * np.sqrt(np.abs(stiffness))),
    )


def _oscillator(motion: CoupledMotion, e: Complexes) -> tuple[complex, complex]:
    """κ = −e*Je and d = −e*Ge of a mode's vector of positions, see `modes_of`."""
    rest = np.zeros(motion.size)
    pulled = motion.along(e.real, rest) + 1j * motion.along(e.imag, rest)
    slowed = motion.along(rest, e.real) + 1j * motion.along(rest, e.imag)
    return complex(-e.conj() @ pulled), complex(-e.conj() @ slowed)


def _extremes(apply: Callable[[Doubles], Doubles], size: int, end: str) -> tuple[Complexes, Complexes]:
    """Eigenvalues at an end of a matrix's spectrum, and eigenvectors, as far as they converge."""
    operator = LinearOperator((size, size), matvec=lambda y: apply(np.asarray(y).ravel()), dtype=float)
    start = np.random.default_rng(0).normal(size=size)
    try:
        values, vectors = eigs(operator, k=EXTREMES, which=end, ncv=VECTORS, maxiter=RESTARTS, tol=RESIDUAL, v0=start)
    except ArpackNoConvergence as trouble:
        values, vectors = trouble.eigenvalues, trouble.eigenvectors
    return np.asarray(values, complex), np.asarray(vectors, complex).reshape(size, -1)

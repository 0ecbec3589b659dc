"""Linear stability of the integration schemes: what a step of length h makes of a mode of motion e^(αt).

A Runge–Kutta method multiplies it by R(hα), its stability function (Hairer & Wanner, Solving Ordinary
Differential Equations II, IV.2). A splitting treats positions and velocities apart, so it acts on the
oscillator a mode belongs to; there the spectral radius of the matrix of its kicks and drifts counts (Hairer,
Lubich & Wanner, Geometric Numerical Integration, I.5.2).
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from particlecli.dynamics.integrators.base import AnyScheme, ClosedForm, RungeKutta, Splitting
from particlecli.stability.modes import Complexes, Doubles, Modes

TOLERANCE = 1e-12
"""Growth in a step that is taken for rounding."""

SHORTEST, LONGEST = 2e-3, 1e3
"""Steps times |α| between which the limit of stability is looked for: a scheme that is unstable at the
shortest is so at any step, one that is stable up to the longest without limit."""

_TRIALS = 2000
_BISECTIONS = 45
_AT_ONCE = 32


def growth(scheme: AnyScheme, modes: Modes, step: Doubles | float) -> Doubles:
    """The factor by which a step multiplies each mode's amplitude.

    Args:
        scheme: the scheme; an adaptive one as if its steps were given.
        modes: the modes.
        step: h, s; broadcast against them.
    """
    match scheme:
        case Splitting():
            return _spectral_radius(scheme, modes, step)
        case ClosedForm():
            with np.errstate(over="ignore"):
                return np.exp(step * modes.rates.real)
        case _:
            factors: Doubles = np.abs(stability_function(scheme, step * modes.rates))
            return factors


def excess(scheme: AnyScheme, modes: Modes, step: Doubles | float) -> Doubles:
    """The factor by which a step multiplies each mode beyond what may be: no growth, or that of the motion.

    Where the mode or its partner grows by itself, the scheme may err by as much again.
    """
    fastest = np.maximum(modes.rates.real, modes.partners.real)
    with np.errstate(over="ignore", invalid="ignore"):
        return growth(scheme, modes, step) / np.exp(np.maximum(2.0 * step * fastest, 0.0))


def stability_function(scheme: RungeKutta, z: Complexes) -> Complexes:
    """R(z) = 1 + z bᵀ (I − zA)⁻¹ 1, as a quotient of polynomials."""
    numerator, denominator = _polynomials(scheme)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        above, below = (np.polynomial.polynomial.polyval(z, each) for each in (numerator, denominator))
        return np.asarray(above / below)


@cache
def _polynomials(scheme: RungeKutta) -> tuple[Doubles, Doubles]:
    """Numerator P and denominator Q of R in ascending powers of z.

    With Q(z) = det(I − zA) the coefficients of P = QR follow from the series R = 1 + Σ bᵀA^k 1 z^(k+1); P is
    at most of the degree of the number of stages.
    """
    b = np.array(scheme.b)
    stages = len(b)
    A = np.array([(*row, *[0.0] * (stages - len(row))) for row in scheme.a])
    denominator = _determinant(A)
    series, slopes = [1.0], np.ones(stages)
    for _ in range(stages):
        series.append(float(b @ slopes))
        slopes = A @ slopes
    return np.convolve(series, denominator)[: stages + 1], denominator


def _determinant(A: Doubles) -> Doubles:
    """Coefficients of det(I − zA) in ascending powers of z (Faddeev–LeVerrier)."""
    size = len(A)
    coefficients, power = [1.0], np.eye(size)
    for k in range(1, size + 1):
        power = A @ power
        coefficients.append(float(-np.trace(power) / k))
        power = power + coefficients[-1] * np.eye(size)
    return np.array(coefficients)


def _spectral_radius(scheme: Splitting, modes: Modes, step: Doubles | float) -> Doubles:
    """Of the matrix that kicks v += c h (−κx − dv) and drifts x += c h v make of the modes' oscillators."""
    one: Complexes = np.ones(np.broadcast_shapes(modes.rates.shape, np.shape(step)), dtype=complex)
    zero: Complexes = np.zeros_like(one)
    xx, xv, vx, vv = one, zero, zero, one
    scale = np.where(modes.rates == 0.0, 1.0, np.abs(modes.rates))  # of x, so that it is of the size of v
    pull, drag, pace = step * modes.stiffness / scale, step * modes.damping, step * scale
    with np.errstate(over="ignore", invalid="ignore"):
        for move, share in scheme.moves:
            if move == "drift":
                xx, xv = xx + share * pace * vx, xv + share * pace * vv
            else:
                vx, vv = vx - share * (pull * xx + drag * vx), vv - share * (pull * xv + drag * vv)
        mean, root = (xx + vv) / 2.0, np.sqrt(((xx - vv) / 2.0) ** 2 + xv * vx)
        return np.fmax(abs(mean + root), abs(mean - root)).astype(np.float64)


def stability_limit(scheme: AnyScheme, modes: Modes) -> tuple[float, complex | None]:
    """The longest step, s, at which all of many modes are stable, and the rate of one that limits it, 1/s.

    Infinite and None where nothing does. As `longest_stable_steps`, but quick: of modes that are alike it looks at
    one, and then at those that turn out to need a slightly shorter step.
    """
    limit, rate = math.inf, None
    candidates = modes.distinct(paired=isinstance(scheme, Splitting))
    while len(candidates.rates):
        steps = longest_stable_steps(scheme, candidates)
        least = int(steps.argmin())
        if not steps[least] < limit:
            break
        limit, rate = float(steps[least]), complex(candidates.rates[least])
        factors = np.where(modes.counting, excess(scheme, modes, limit), 0.0)
        worst = np.argsort(-factors)[:_AT_ONCE] if limit > 0.0 else np.array([], dtype=int)
        candidates = modes.at(worst[factors[worst] > 1.0 + TOLERANCE])
    return limit, rate


def longest_stable_steps(scheme: AnyScheme, modes: Modes) -> Doubles:
    """For each mode the longest step, s, up to which it never grows by more than may be, see `excess`.

    Infinite where there is no limit, and for modes that do not count; 0 where every step lets it grow. Gaps
    in stability narrower than a percent of the step are not seen.

    Args:
        scheme: the scheme.
        modes: of shape (m,).
    """
    limits = np.full(modes.rates.shape, np.inf)
    counting = np.flatnonzero(modes.counting)
    if len(counting):
        limits[counting] = _limits(scheme, modes.at(counting))
    return limits


def _limits(scheme: AnyScheme, modes: Modes) -> Doubles:
    scaled = np.geomspace(SHORTEST, LONGEST, _TRIALS)
    size = np.abs(modes.rates)
    unstable = ~(excess(scheme, modes.shaped(-1, 1), scaled / size[:, None]) <= 1.0 + TOLERANCE)
    first = unstable.argmax(axis=1)
    low, high = scaled[np.maximum(first - 1, 0)], scaled[first]
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2.0
        stable = excess(scheme, modes, middle / size) <= 1.0 + TOLERANCE
        low, high = np.where(stable, middle, low), np.where(stable, high, middle)
    return np.where(unstable.any(axis=1), np.where(first == 0, 0.0, low), np.inf) / size

"""How errors of pilots go on growing after what was flown.

Where the motion is orderly they are taken to grow as time does. Where it is chaotic, neighbouring solutions part
exponentially: with e(t) the distance that 95 in 100 particles do not exceed, ln e(t) is a line of slope λ, so that
from the end t₁ of the pilot to the end T of the scene an error becomes

    e(T) = e(t₁) · min(exp(λ (T − t₁)), d / δ(t₁)).

The second bound is the span for which a solution can be followed at all: δ is how far the two best solutions that can
be had are apart, it grows at the same rate, and at a distance d of them nothing is known any longer.
λ is fitted to the last half of what was flown, as in G. Benettin, L. Galgani & J.-M. Strelcyn, Phys. Rev. A 14 (1976)
2338, but to distances that integration itself has made.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

ORDERLY = 3.0
"""The highest power of time by which errors of orderly motion grow: a wrong acceleration makes them grow as its square,
one that itself goes wrong steadily as its cube."""

LOST = 0.5
"""Share of the particles that live on after a pilot's flight of which nothing is known where it ends: chaos then
takes the rest of their way, which no longer counts."""

HUGE = 700.0
"""The largest exponent of a number that can still be had."""

FEWEST = 3
"""Frames that a rate is fitted to, at least."""


def growth_rate(sizes: NDArray[np.float64]) -> float:
    """The rate of exponential growth, per frame, of errors at frames 1, 2, …; 0 if they grow no faster than a power."""
    frames = np.arange(1, len(sizes) + 1)
    late = 2 * frames >= len(sizes)
    frames, late_sizes = frames[late], sizes[late]
    if len(frames) < FEWEST or not (np.isfinite(late_sizes) & (late_sizes > 0.0)).all():
        return 0.0
    logarithms = np.log(late_sizes)
    power = float(np.polyfit(np.log(frames), logarithms, 1)[0])
    return float(np.polyfit(frames, logarithms, 1)[0]) if power > ORDERLY else 0.0


def growth(flown: int, frames: int, *, lost: float = 0.0, rate: float = 0.0, bound: float = math.inf) -> float:
    """By how much errors grow from the end of a pilot's flight to that of the scene; they are not taken to shrink.

    Args:
        flown: frames that were flown.
        frames: those that particles live.
        lost: share of the particles of which nothing is known where the flight ends, of those that live on.
        rate: of exponential growth, per frame; 0 where the motion is orderly.
        bound: by how much more errors can grow as long as a solution can be followed, d / δ(t₁).
    """
    if lost > LOST:
        return 1.0
    most = frames / flown if not rate else min(math.exp(min(rate * (frames - flown), HUGE)), bound)
    return max(1.0, most)

"""Random numbers that depend on nothing but (seed, group, birth index, what they are for).

Philox4x32-10, the counter-based generator of Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as
easy as 1, 2, 3" (SC11): ten rounds of a keyed bijection on a 128-bit counter. There is no state to share or
advance, so the numbers are the same in whatever order, portion or process they are asked for.
"""

from __future__ import annotations

import hashlib
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from particlecli.scene.distributions import Choice, Distribution, LogNormal, Normal, Uniform

Array = NDArray[np.float64]
Words = NDArray[np.uint64]

MULTIPLIERS = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
KEY_STEPS = 0x9E3779B9, 0xBB67AE85
ROUNDS = 10
LOW = np.uint64(0xFFFFFFFF)
HALF = np.uint64(32)

CHUNK = 8192
"""Counters hashed at a time: the working arrays stay in the second-level cache."""


class Draw(IntEnum):
    """What a random number is for.

    Each quantity has its number for ever; new ones are added at the end and change no other's values. Numbers
    2k and 2k + 1 come out of one hash, so quantities that are mostly drawn together are neighbours.
    """

    POSITION_1 = 0
    POSITION_2 = 1
    POSITION_3 = 2
    SPEED = 3
    DIRECTION_1 = 4
    DIRECTION_2 = 5
    LIFETIME = 6
    TEMPERATURE = 7
    MASS = 8
    COOLING_RATE = 9
    VELOCITY_X = 10
    VELOCITY_Y = 11
    VELOCITY_Z = 12


def random_key(seed: int, name: str) -> tuple[int, int]:
    """The generator's key, two 32-bit words, of a scene's `seed` (below 2⁶⁴) and a group's name."""
    digest = hashlib.blake2b(seed.to_bytes(8, "little") + name.encode(), digest_size=8).digest()
    return int.from_bytes(digest[:4], "little"), int.from_bytes(digest[4:], "little")


def philox4x32(counters: Words, key: tuple[int, int]) -> Words:
    """Philox4x32-10 of many counters.

    Args:
        counters: shape (4, n), words below 2³² (held in 64 bits, so that products do not overflow).
        key: two words below 2³².

    Returns:
        Shape (4, n), words below 2³².
    """
    c0, c1, c2, c3 = counters.copy()
    product0, product1 = np.empty_like(c0), np.empty_like(c0)
    for turn in range(ROUNDS):
        key0 = np.uint64((key[0] + turn * KEY_STEPS[0]) & 0xFFFFFFFF)
        key1 = np.uint64((key[1] + turn * KEY_STEPS[1]) & 0xFFFFFFFF)
        np.multiply(c0, MULTIPLIERS[0], out=product0)
        np.multiply(c2, MULTIPLIERS[1], out=product1)
        np.right_shift(product1, HALF, out=c0)
        c0 ^= c1
        c0 ^= key0
        np.right_shift(product0, HALF, out=c2)
        c2 ^= c3
        c2 ^= key1
        np.bitwise_and(product1, LOW, out=c1)
        np.bitwise_and(product0, LOW, out=c3)
    return np.stack((c0, c1, c2, c3))


class Draws:
    """The random numbers of some particles of one group.

    Attributes:
        indices: shape (n,), the particles' birth indices.
    """

    def __init__(self, seed: int, name: str, indices: NDArray[np.integer]) -> None:
        self.indices = indices.astype(np.uint64)
        self._key = random_key(seed, name)
        self._spare: dict[int, Array] = {}

    def __len__(self) -> int:
        return len(self.indices)

    def uniform(self, draw: int) -> Array:
        """Shape (n,): uniform in the open interval (0, 1), multiples of 2⁻⁵³, symmetric about ½."""
        if draw in self._spare:
            return self._spare.pop(draw)
        pair = self._pair(draw // 2)
        self._spare[draw ^ 1] = pair[1 - draw % 2]
        return pair[draw % 2]

    def _pair(self, block: int) -> tuple[Array, Array]:
        first, second = np.empty(len(self)), np.empty(len(self))
        for start in range(0, len(self), CHUNK):
            part = slice(start, start + CHUNK)
            indices = self.indices[part]
            counters = np.zeros((4, len(indices)), np.uint64)
            counters[0] = indices & LOW
            counters[1] = indices >> HALF
            counters[2] = block
            words = philox4x32(counters, self._key)
            first[part] = _open_interval(words[0], words[1])
            second[part] = _open_interval(words[2], words[3])
        return first, second


def _open_interval(high: Words, low: Words) -> Array:
    """52 random bits and a half, over 2⁵²: one bit more would round the largest value to 1."""
    bits = (high << np.uint64(20)) | (low >> np.uint64(12))
    numbers = bits.astype(np.float64)
    numbers += 0.5
    numbers *= 2.0**-52
    return numbers


def sample(value: float | Distribution, draws: Draws, draw: Draw) -> Array:
    """Shape (n,): the quantity `draw` of every particle, each from one uniform number.

    A plain number is the same for all. Continuous distributions are inverted, so a larger uniform number
    gives a larger value; none lies outside the distribution's `support`, which the scene was checked against.
    """
    if isinstance(value, (int, float)):
        return np.full(len(draws), float(value))
    uniform = draws.uniform(draw)
    match value:
        case Uniform():
            low, high = value.uniform
            numbers = (1.0 - uniform) * low + uniform * high
        case Normal():
            numbers = _normal(value, uniform)
        case LogNormal():
            median, deviation = value.log_normal
            numbers = median * np.exp(deviation * _normal(Normal(normal=(0.0, 1.0)), uniform))
        case Choice():
            return _choice(value, uniform)
    lowest, highest = value.support
    return np.clip(numbers, lowest, highest, out=numbers)


def _normal(value: Normal, uniform: Array) -> Array:
    """The truncated normal: x = μ + σ Φ⁻¹(Φ(a) + U (Φ(b) − Φ(a))) between a and b standard deviations."""
    from scipy.special import ndtr, ndtri  # slow to import, and most scenes need none

    mean, sigma = value.normal
    if sigma == 0:
        return np.full_like(uniform, mean)
    below, above = (ndtr((end - mean) / sigma) for end in value.support)
    deviations: Array = ndtri(below + uniform * (above - below))
    return mean + sigma * deviations


def _choice(value: Choice, uniform: Array) -> Array:
    weights = np.ones(len(value.choice)) if value.weights is None else np.asarray(value.weights)
    ends = np.cumsum(weights / weights.max())
    return np.asarray(value.choice)[np.searchsorted(ends / ends[-1], uniform, side="right")]

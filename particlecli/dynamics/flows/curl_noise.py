"""Turbulence without sources or sinks, made of random waves."""

import hashlib
import math
from statistics import NormalDist

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli.dynamics.flows.base import FlowTerm
from particlecli.dynamics.vector_math import cos_turns
from particlecli.scene import flows as scene

MODES_PER_OCTAVE = 12
"""Waves in each octave of wavelengths: enough that no direction or period shows."""

_SWEEPS = 8
"""Passes over the waves of an octave after which its energy is the same in all directions, within 1 %."""

_GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


class CurlNoise(FlowTerm[scene.CurlNoiseFlow]):
    """u = ∇ × ψ of a random Fourier potential ψ, that is u = Σ c cos(2π (k · x + f t + φ)) with c ⟂ k.

    Symbols: k wave vector, turns/m; f frequency, Hz; φ phase, turns; c amplitude, m/s. As every c is
    perpendicular to its k, the divergence is zero everywhere. In octave j the wavelengths 1/|k| lie about
    length/2ʲ, a factor √2 to both sides. The speed of an eddy grows with its size as |k|^(−1/3) and its
    lifetime as |k|^(−2/3), as in Kolmogorov's spectrum E ~ |k|^(−5/3); f is normal with the standard
    deviation 1/lifetime. The root mean square of |u| over all space is the scene's `speed`.
    Source: Kraichnan, Phys. Fluids 13 (1970) 22, "Diffusion by a random velocity field"; Kolmogorov (1941).
    """

    def __init__(self, spec: scene.CurlNoiseFlow, scene_seed: int = 0) -> None:
        super().__init__(spec)
        self.table = modes(spec, scene_seed)

    @ti.func
    def velocity(self, p, x, t):
        """The velocity, m/s."""
        ux, uy, uz = x[0] * 0.0, x[0] * 0.0, x[0] * 0.0
        for mode in range(self.rows.shape[0]):
            phase = self.rows[mode, 3] * t + self.rows[mode, 4]
            along = self.rows[mode, 0] * x[0] + self.rows[mode, 1] * x[1] + self.rows[mode, 2] * x[2]
            wave = cos_turns(along + phase)
            ux += self.rows[mode, 5] * wave
            uy += self.rows[mode, 6] * wave
            uz += self.rows[mode, 7] * wave
        return ux, uy, uz

    @ti.func
    def gradient(self, p, x, t):
        """The derivatives by position, 1/s."""
        slopes = [x[0] * 0.0 for _ in ti.static(range(9))]
        for mode in range(self.rows.shape[0]):
            phase = self.rows[mode, 3] * t + self.rows[mode, 4]
            along = self.rows[mode, 0] * x[0] + self.rows[mode, 1] * x[1] + self.rows[mode, 2] * x[2]
            wave = math.tau * cos_turns(along + phase + 0.25)
            for i in ti.static(range(3)):
                for j in ti.static(range(3)):
                    slopes[3 * i + j] += self.rows[mode, 5 + i] * self.rows[mode, j] * wave
        return slopes[0:3], slopes[3:6], slopes[6:9]


def modes(spec: scene.CurlNoiseFlow, scene_seed: int) -> NDArray[np.float64]:
    """The waves of a turbulence: shape (octaves · MODES_PER_OCTAVE, 8), columns k (3), f, φ, c (3)."""
    text = f"curl_noise {scene_seed} {spec.seed}"
    key = int.from_bytes(hashlib.blake2b(text.encode(), digest_size=16).digest(), "little")
    random = np.random.Generator(np.random.Philox(key=key))
    table = np.concatenate([_octave(spec, octave, random) for octave in range(spec.octaves)])
    table[:, 5:] *= spec.speed * np.sqrt(2 / (table[:, 5:] ** 2).sum())
    return table


def _octave(spec: scene.CurlNoiseFlow, octave: int, random: np.random.Generator) -> NDArray[np.float64]:
    direction = _directions(random)
    spread = (_shuffled(random) + random.random(MODES_PER_OCTAVE)) / MODES_PER_OCTAVE - 0.5
    relative = 2.0 ** (octave + spread)
    normal = [NormalDist().inv_cdf((rank + 0.5) / MODES_PER_OCTAVE) for rank in _shuffled(random)]
    rate = 0.0 if spec.lifetime is None else relative ** (2 / 3) / spec.lifetime
    phase = random.random(MODES_PER_OCTAVE)
    return np.column_stack(
        [
            direction * (relative / spec.length)[:, None],
            np.array(normal) * rate,
            phase,
            _amplitudes(direction, relative ** (-1 / 3)),
        ]
    )


def _shuffled(random: np.random.Generator) -> NDArray[np.int64]:
    # Generator.permutation may change between versions of NumPy, its uniform doubles may not.
    return np.argsort(random.random(MODES_PER_OCTAVE))


def _directions(random: np.random.Generator) -> NDArray[np.float64]:
    """Unit vectors spread evenly over half a sphere (k and −k are the same wave), turned at random."""
    height = (np.arange(MODES_PER_OCTAVE) + 0.5) / MODES_PER_OCTAVE
    azimuth = _GOLDEN_ANGLE * np.arange(MODES_PER_OCTAVE)
    radius = np.sqrt(1 - height**2)
    points = np.column_stack([radius * np.cos(azimuth), radius * np.sin(azimuth), height])
    return points @ _rotation(*random.random(3)).T


def _rotation(share: float, first: float, second: float) -> NDArray[np.float64]:
    """A uniformly distributed rotation from three uniform numbers (Shoemake, Graphics Gems III, 1992)."""
    a, b = np.sqrt(1 - share), np.sqrt(share)
    x, y = a * np.sin(2 * np.pi * first), a * np.cos(2 * np.pi * first)
    z, w = b * np.sin(2 * np.pi * second), b * np.cos(2 * np.pi * second)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _amplitudes(direction: NDArray[np.float64], size: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors of given sizes at right angles to the directions, together as even in all directions as can be.

    Each goes where those before it have left the least energy: along the minor axis of their covariance, seen
    along its wave vector.
    """
    smallest = np.eye(3)[np.abs(direction).argmin(axis=1)]
    first = np.cross(direction, smallest)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(direction, first)
    result = np.zeros_like(direction)
    covariance = np.zeros((3, 3))
    for _ in range(_SWEEPS):
        for mode, (e, f) in enumerate(zip(first, second, strict=True)):
            others = covariance - np.outer(result[mode], result[mode])
            angle = np.arctan2(2 * (e @ others @ f), e @ others @ e - f @ others @ f) / 2 + np.pi / 2
            result[mode] = size[mode] * (np.cos(angle) * e + np.sin(angle) * f)
            covariance = others + np.outer(result[mode], result[mode])
    return result

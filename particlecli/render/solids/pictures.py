"""The shipped sheets of pictures, computed when first used: smoke, flames, snowflakes and leaves.

A sheet has the shape (pictures, SIZE, SIZE, 4): linear light, multiplied by how much it hides, and how much it hides.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from particlecli.scene.look import SHEETS

Doubles = NDArray[np.float64]
Floats = NDArray[np.float32]

SIZE = 128
"""Texels across a picture."""


def _plane() -> tuple[Doubles, Doubles]:
    """Coordinates of the texels in −1..1, to the right and up."""
    place = (np.arange(SIZE) + 0.5) * 2 / SIZE - 1
    across, down = np.meshgrid(place, place)
    return across, -down


def _noise(x: Doubles, y: Doubles, z: float, seed: int) -> Doubles:
    """Smooth noise in −1..1, of a length of 1, as a trilinear blend of a lattice of random values (value noise)."""
    lattice = np.random.default_rng(seed).uniform(-1, 1, (32, 32, 32))
    parts = [np.floor(each).astype(int) for each in (x, y, np.full_like(x, z))]
    ramps = [each - part for each, part in zip((x, y, np.full_like(x, z)), parts, strict=True)]
    a, b, c = (t * t * t * (t * (6 * t - 15) + 10) for t in ramps)
    total = np.zeros_like(x)
    for corner in range(8):
        i, j, k = corner & 1, corner >> 1 & 1, corner >> 2
        weight = (a if i else 1 - a) * (b if j else 1 - b) * (c if k else 1 - c)
        total += weight * lattice[(parts[0] + i) % 32, (parts[1] + j) % 32, (parts[2] + k) % 32]
    return total


def _billows(x: Doubles, y: Doubles, z: float, seed: int) -> Doubles:
    """Four octaves of noise."""
    return np.asarray(sum(0.5**o * _noise(2**o * x, 2**o * y, 2**o * z, seed + o) for o in range(4)))


def _stack(light: list[Doubles], hides: list[Doubles]) -> Floats:
    """Pictures from light, shape (SIZE, SIZE) or (SIZE, SIZE, 3), and how much it hides, by which it is multiplied."""
    pictures = []
    for brightness, cover in zip(light, hides, strict=True):
        color = brightness if brightness.ndim == 3 else np.repeat(brightness[..., None], 3, axis=2)
        pictures.append(np.concatenate([color * cover[..., None], cover[..., None]], axis=-1))
    return np.stack(pictures).astype(np.float32)


@cache
def smoke() -> Floats:
    """Sixteen pictures of a puff that billows out and frays, brighter above where light falls on it."""
    x, y = _plane()
    light, hides = [], []
    for share in np.linspace(0, 1, 16):
        swirl = 0.35 * _billows(1.6 * x + 3, 1.6 * y, 1.2 * share, 11)
        distance = np.hypot(x + 0.4 * swirl, y - 0.3 * swirl) + 0.5 * (0.6 + share) * _billows(
            2.2 * x, 2.2 * y - 0.8 * share, 2 + 0.9 * share, 3
        )
        body = np.clip((0.72 - distance) / (0.5 + 0.4 * share), 0, 1)
        body *= np.clip(2.6 * (1 - np.hypot(x, y)), 0, 1)
        density = body * body * (3 - 2 * body)
        shading = 0.62 + 0.38 * np.tanh(2.2 * (np.roll(density, 9, axis=0) * -0.9 + 0.45 + 0.35 * y + 0.3 * x))
        light.append(np.clip(shading, 0.15, 1.15))
        hides.append(density * (1 - 0.35 * share))
    return _stack(light, hides)


@cache
def flame() -> Floats:
    """Sixteen pictures of a tongue of fire that licks up and comes apart, white inside and red outside."""
    x, y = _plane()
    light, hides = [], []
    for share in np.linspace(0, 1, 16):
        lick = 0.3 * (y + 1) * _billows(1.3 * x + 7, 1.3 * y - 3 * share, 2 * share, 21)
        width = 0.5 * np.sqrt(np.clip((y + 0.9) / 0.5, 0, 1)) * np.clip((0.95 - y) / 1.5, 0, 1) ** 0.8
        heat = 1 - np.abs(x + lick) / np.maximum(width, 1e-3)
        heat = heat - (0.35 + 0.9 * share) * np.abs(_billows(2.5 * x, 2 * y - 4 * share, 3 * share, 31)) - 0.5 * share
        heat = np.clip(heat, 0, 1) * (width > 0.01)
        light.append(np.stack([np.minimum(1.6 * heat**0.5, 1.5), 0.9 * heat**1.3, 0.35 * heat**3], axis=-1))
        hides.append(np.clip(1.5 * heat, 0, 1))
    return _stack(light, hides)


@cache
def snow() -> Floats:
    """Eight snowflakes of six branches each, every one another."""
    x, y = _plane()
    distance, angle = np.hypot(x, y), np.arctan2(y, x)
    folded = np.abs((angle + np.pi / 6) % (np.pi / 3) - np.pi / 6)
    along, aside = distance * np.cos(folded), distance * np.sin(folded)
    hides = []
    for number in range(8):
        random = np.random.default_rng(number)
        cover = np.clip((0.045 - aside) * 40, 0, 1) * np.clip((0.9 - along) * 30, 0, 1)
        cover = np.maximum(cover, np.clip((random.uniform(0.1, 0.3) - along) * 40, 0, 1) * 0.75)
        for root in random.uniform(0.2, 0.75, 4):
            reach = random.uniform(0.12, 0.36) * (1.1 - root)
            start = along - root
            twig = np.abs(start * np.sin(np.pi / 3) - aside * np.cos(np.pi / 3))
            out = start * np.cos(np.pi / 3) + aside * np.sin(np.pi / 3)
            inside = np.clip((0.032 - twig) * 40, 0, 1) * np.clip(out * 40, 0, 1) * np.clip((reach - out) * 40, 0, 1)
            cover = np.maximum(cover, inside)
        hides.append(cover)
    return _stack([np.ones_like(x)] * 8, hides)


@cache
def leaf() -> Floats:
    """Sixteen pictures of a leaf that turns over: seen from the front, from the side, from the back."""
    x, y = _plane()
    light, hides = [], []
    for number in range(16):
        turn = np.cos(2 * np.pi * (number + 0.25) / 16)
        across = x / max(abs(turn), 0.12)
        outline = 0.42 * np.clip(1 - np.abs(y) / 0.86, 0, 1) ** 0.7 * (1.15 + 0.4 * y)
        cover = np.clip((outline - np.abs(across)) * 34, 0, 1)
        stalk = np.clip((0.02 - np.abs(across)) * 60, 0, 1) * (y < -0.6) * (y > -0.98)
        rib = np.exp(-((across / 0.025) ** 2)) + 0.6 * np.exp(-((np.sin(16 * (y - 0.9 * np.abs(across))) / 0.22) ** 2))
        shade = (0.75 + 0.25 * np.sign(turn) * np.tanh(4 * across)) * (1.0 if turn > 0 else 0.8)
        light.append(shade * (1 - 0.22 * np.clip(rib, 0, 1)))
        hides.append(np.maximum(cover, stalk))
    return _stack(light, hides)


SHIPPED: dict[str, Callable[[], Floats]] = dict(zip(SHEETS, (smoke, flame, snow, leaf), strict=True))
"""The sheets by name."""

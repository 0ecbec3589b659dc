"""The light that falls on bodies: one lamp far away, and soft light from above and from the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from particlecli.render.colour import from_hex
from particlecli.scene.look import Light

Doubles = NDArray[np.float64]

WRAP = 0.15
"""How far the lamp's light reaches around a body, as if it were scattered within."""

BOUNCE = 0.35
"""Light from the ground, as a share of that from the sky."""

SOFTBOX = (0.955, 0.985)
"""Cosines of the angle to the lamp at which its reflection begins and is full."""


@dataclass(frozen=True)
class Lighting:
    """The light of a scene.

    Attributes:
        direction: where the lamp is, shape (3,), of length 1.
        lamp, sky: linear sRGB, shape (3,).
    """

    direction: Doubles
    lamp: Doubles
    sky: Doubles

    @classmethod
    def of(cls, light: Light) -> Lighting:
        """The light that a scene describes."""
        return cls(np.array(light.direction), light.brightness * from_hex(light.color), from_hex(light.sky))

    def soft(self, normals: Doubles) -> Doubles:
        """Light from sky and ground on surfaces, shape (…, 3), of unit normals, shape (…, 3)."""
        up = 0.5 + 0.5 * normals[..., 1:2]
        return (BOUNCE + (1.0 - BOUNCE) * up) * self.sky

    def on(self, normals: Doubles) -> Doubles:
        """All light on matt surfaces, shape (…, 3), of unit normals, shape (…, 3)."""
        facing = np.maximum((normals @ self.direction + WRAP) / (1.0 + WRAP), 0.0)
        return facing[..., None] * self.lamp + self.soft(normals)

    def around(self, directions: Doubles) -> Doubles:
        """What is seen in unit directions, shape (…, 3): sky, ground, a bright horizon, and the lamp as a soft box."""
        height = directions[..., 1:2]
        horizon = np.exp(-((height / 0.25) ** 2))
        box = _smooth((directions @ self.direction - SOFTBOX[0]) / (SOFTBOX[1] - SOFTBOX[0]))
        above = np.where(height > 0, 0.55 + 0.45 * height, BOUNCE)
        return (above + 0.7 * horizon) * self.sky + 9.0 * box[..., None] * self.lamp


def _smooth(t: Doubles) -> Doubles:
    s = np.clip(t, 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)

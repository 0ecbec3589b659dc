"""How a sphere looks from the front, worked out once for all spheres of a group: its shading as a table.

A cap is seen along the camera's axis with the light far away, so its shading depends on nothing but the place on its
disc. Each texel is the light that takes the tint (3), how much it hides, the light that does not (3), and nothing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.render.camera import View
from particlecli.render.solids.light import Doubles, Lighting

TEXELS = 128
"""Across a cap."""

INDEX = 1.45
"""Of refraction, of what clear spheres are made of."""

SHARPNESS = 90.0
"""Exponent of the highlight (Blinn 1977)."""


def cap(view: View, light: Lighting, opacity: float) -> NDArray[np.float32]:
    """The cap and its levels, each half as fine, shape (texels, 8)."""
    levels = []
    size = TEXELS
    while size >= 1:
        levels.append(_cap(view, light, opacity, size).reshape(-1, 8))
        size //= 2
    return np.concatenate(levels).astype(np.float32)


def _cap(view: View, light: Lighting, opacity: float, size: int) -> Doubles:
    across, down = np.meshgrid(*2 * [(np.arange(size) + 0.5) * 2 / size - 1])
    length = np.hypot(across, down)
    inward = np.minimum(1.0, 0.985 / np.maximum(length, 1e-9))
    across, down, length = across * inward, down * inward, np.minimum(length, 0.985)
    toward = np.sqrt(1.0 - length**2)
    normals = across[..., None] * view.right - down[..., None] * view.up - toward[..., None] * view.forward
    mirrored = view.forward + 2 * toward[..., None] * normals
    fresnel = 0.04 + 0.96 * (1.0 - toward) ** 5
    half = light.direction - view.forward
    shine = np.maximum(normals @ (half / np.linalg.norm(half)), 0.0) ** SHARPNESS
    matt = light.on(normals)
    gloss = fresnel[..., None] * light.around(mirrored) + 0.9 * shine[..., None] * light.lamp
    clear = light.around(refracted(view, across, down, length, toward))
    through = (1.0 - opacity) * (0.2 + 0.8 * length[..., None] ** 4)
    rim = 0.12 + 0.88 * np.maximum(fresnel, length**6)
    hides = opacity + (1.0 - opacity) * rim
    return np.concatenate(
        [opacity * matt + 0.8 * through * clear, hides[..., None], gloss, np.zeros((size, size, 1))], axis=-1
    )


def refracted(view: View, across: Doubles, down: Doubles, length: Doubles, toward: Doubles) -> Doubles:
    """Where a ray leaves for that goes straight into a clear sphere, and is refracted twice; shape (…, 3).

    It is turned towards the axis by 2 (θ − θ'), sin θ = n sin θ' = its distance from the axis.
    """
    sine = length / INDEX
    cosine = np.sqrt(1.0 - sine**2)
    turn_sine, turn_cosine = length * cosine - toward * sine, toward * cosine + length * sine
    double_sine, double_cosine = 2 * turn_sine * turn_cosine, turn_cosine**2 - turn_sine**2
    outward = (across[..., None] * view.right - down[..., None] * view.up) / np.maximum(length, 1e-9)[..., None]
    return double_cosine[..., None] * view.forward - double_sine[..., None] * outward

"""What a liquid looks like by where its surface faces, worked out once for a group: its shading as a table.

A texel is the light of a matt surface that takes the tint (3), the share of light that is mirrored, what is mirrored
(3), and the light that comes through where it is clear. See `solids.caps`, which does so for balls.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.render.camera import View
from particlecli.render.colour import LUMINANCE
from particlecli.render.solids.caps import refracted
from particlecli.render.solids.light import Lighting
from particlecli.scene.look import Liquid

TEXELS = 160
"""Across a table."""

LEAST = 0.035
"""Share of light that liquids mirror straight back."""

GRAZING = 0.6
"""Share of light that they mirror where they are seen from the side; less than all of it, as no surface is smooth."""

SHARPNESS = 140.0
"""Exponent of the highlight (Blinn 1977)."""


def table_of(view: View, light: Lighting, liquid: Liquid) -> NDArray[np.float32]:
    """The table of a liquid, shape (TEXELS², 8): faces to the right along rows, faces downwards from row to row."""
    across, down = np.meshgrid(*2 * [np.linspace(-1.0, 1.0, TEXELS)])
    length = np.hypot(across, down)
    inward = np.minimum(1.0, 0.999 / np.maximum(length, 1e-9))
    across, down, length = across * inward, down * inward, np.minimum(length, 0.999)
    toward = np.sqrt(1.0 - length**2)
    normals = across[..., None] * view.right - down[..., None] * view.up - toward[..., None] * view.forward
    mirrored = view.forward + 2 * toward[..., None] * normals
    straight = LEAST + (1.0 - LEAST) * liquid.metal
    fresnel = straight + (max(GRAZING, straight) - straight) * (1.0 - toward) ** 5
    half = light.direction - view.forward
    shine = np.maximum(normals @ (half / np.linalg.norm(half)), 0.0) ** SHARPNESS
    gloss = fresnel[..., None] * light.around(mirrored) + 1.2 * shine[..., None] * light.lamp
    clear = light.around(refracted(view, across, down, length, toward)) @ LUMINANCE
    matt = (1.0 - liquid.metal) * light.on(normals) + liquid.glow * (0.45 + 0.55 * toward[..., None])
    through = 0.1 * clear + 0.5 * clear * length**4
    parts = [matt, fresnel[..., None], gloss, through[..., None]]
    return np.concatenate(parts, axis=-1).reshape(-1, 8).astype(np.float32)

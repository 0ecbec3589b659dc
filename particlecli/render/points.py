"""Particles as plain points: their colours and sizes for viewers that draw for themselves. No Taichi."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import Floats, GroupFrame
from particlecli.render.colour import encode
from particlecli.render.tint import Tint, tint_of
from particlecli.scene.look import PLAIN_PIXELS, GroupLook

Colors = NDArray[np.uint32]

SHADES = 256
"""Colours of a palette, at most."""


class PointLook:
    """How the points of a group look.

    Light that is brighter than white keeps its hue; what is fainter is darker.

    Args:
        style: what the scene says.
        place: the group's place in the scene, from 0.

    Attributes:
        needs: fields of a frame that the colours are computed from.
        radius: of a point, m; negative: pixels of a picture of 720 lines.
        palette: the colours as 0xRRGGBBAA, opaque: shape (k,), or (1,) where all points are alike.
    """

    def __init__(self, style: GroupLook, place: int) -> None:
        self._tint = tint_of(style.color, place)
        self.needs = self._tint.needs
        self.radius = style.radius or -(style.pixels or PLAIN_PIXELS)
        last = self._tint.last
        chosen = np.round(np.linspace(0, last, min(SHADES, last + 1))).astype(np.intp)
        self.palette = _packed(self._tint.table[chosen, :3], style.brightness)

    def shades(self, group: GroupFrame) -> NDArray[np.uint16] | None:
        """The place of each particle's colour in the palette, shape (n,); none where all are alike."""
        tint, last = self._tint, len(self.palette) - 1
        quantity = quantity_of(group, tint)
        if quantity is None:
            return None
        places = (quantity - tint.low) * (last / (tint.high - tint.low))
        np.fmax(places, 0, out=places)  # and what is not a number becomes 0
        np.minimum(places, last, out=places)
        return np.asarray(np.rint(places, out=places), np.uint16)


def quantity_of(group: GroupFrame, tint: Tint) -> Floats | None:
    """What a tint looks up, shape (n,); none where it is one colour."""
    match tint.quantity:
        case "none":
            return None
        case "age":
            assert group.ages is not None
            return group.ages if group.lifetimes is None else group.ages / group.lifetimes
        case "speed":
            assert group.velocities is not None
            speed: Floats = np.sqrt(np.einsum("ni,ni->n", group.velocities, group.velocities))
            return speed
        case "temperature":
            assert group.temperatures is not None
            return group.temperatures
        case "id":
            return group.ids.astype(np.float64)


def _packed(table: NDArray[np.float32], brightness: float) -> Colors:
    light = brightness * table.astype(np.float64)
    light /= np.maximum(1.0, light.max(axis=1, keepdims=True))
    red, green, blue = np.round(255 * encode(np.maximum(light, 0.0))).astype(np.uint32).T
    return np.asarray(red << 24 | green << 16 | blue << 8 | 255, np.uint32)

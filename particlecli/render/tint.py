"""How a group's particles are coloured: a quantity of each particle looked up in a table of light."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, assert_never

import numpy as np
from numpy.typing import NDArray

from particlecli.render.blackbody import glow
from particlecli.render.colour import LUMINANCE, from_hex
from particlecli.render.palettes import GROUP_COLORS, colormap
from particlecli.scene.look import Blackbody, ByGroup, Color, Constant, Mapped

Quantity = Literal["none", "age", "speed", "temperature", "id"]

STEPS = 4096
"""Places in a table; a place number and a 12-bit fraction fit a 32-bit float, which the splats rely on."""


@dataclass(frozen=True)
class Tint:
    """Colours over a quantity.

    Attributes:
        quantity: what of a particle is looked up.
        low, high: the quantity at the first and the last place of the table; beyond them the ends hold.
        table: shape (places, 4): linear sRGB light and its luminance.
    """

    quantity: Quantity
    low: float
    high: float
    table: NDArray[np.float32]

    @property
    def last(self) -> int:
        """The last place."""
        return len(self.table) - 1

    @property
    def needs(self) -> frozenset[str]:
        """Fields of a frame that the quantity is computed from."""
        fields: dict[Quantity, frozenset[str]] = {
            "none": frozenset(),
            "age": frozenset({"ages", "lifetimes"}),
            "speed": frozenset({"velocities"}),
            "temperature": frozenset({"temperatures"}),
            "id": frozenset(),
        }
        return fields[self.quantity]


def tint_of(color: Color, place: int) -> Tint:
    """The tint that a scene's colour asks for; `place` is the group's place in the scene, from 0."""
    match color:
        case Constant():
            return Tint("none", 0.0, 1.0, _with_luminance(from_hex([color.constant])))
        case ByGroup():
            return Tint("none", 0.0, 1.0, _with_luminance(from_hex([GROUP_COLORS[place % len(GROUP_COLORS)]])))
        case Blackbody(blackbody=reference):
            return _blackbody(reference)
        case Mapped():
            low, high = color.range or (0.0, 1.0)
            return Tint(color.by, low, high, _with_luminance(colormap(color.map, STEPS)))
        case _:
            assert_never(color)


@lru_cache(maxsize=16)
def _blackbody(reference: float) -> Tint:
    low, high = 0.25 * reference, 3.0 * reference
    return Tint("temperature", low, high, _with_luminance(glow(np.linspace(low, high, STEPS), reference)))


def _with_luminance(linear: NDArray[np.float64]) -> NDArray[np.float32]:
    return np.concatenate([linear, linear @ LUMINANCE[:, None]], axis=1).astype(np.float32)

"""Named colormaps, and colours for groups."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from particlecli.render.colour import from_hex, from_oklab, to_oklab
from particlecli.scene.look import Palette

# inferno … twilight: matplotlib's, at 17 equally spaced places; ice, fire and aurora are this package's own.
PALETTES: dict[Palette, str] = {
    "inferno": (
        "#000004 #0b0724 #210c4a #3d0965 #57106e #71196e #8a226a #a32c61 #bc3754 "
        "#d24644 #e45a31 #f1731d #f98e09 #fcac11 #f9cb35 #f2ea69 #fcffa4"
    ),
    "magma": (
        "#000004 #0a0822 #1d1147 #36106b #51127c #6a1c81 #832681 #9c2e7f #b73779 "
        "#d0416f #e75263 #f56b5c #fc8961 #fea772 #fec488 #fde2a3 #fcfdbf"
    ),
    "plasma": (
        "#0d0887 #310597 #4c02a1 #6600a7 #7e03a8 #9511a1 #aa2395 #bc3587 #cc4778 "
        "#da5a6a #e66c5c #f0804e #f89540 #fdac33 #fdc527 #f8df25 #f0f921"
    ),
    "viridis": (
        "#440154 #48186a #472d7b #424086 #3b528b #33638d #2c728e #26828e #21918c "
        "#1fa088 #28ae80 #3fbc73 #5ec962 #84d44b #addc30 #d8e219 #fde725"
    ),
    "turbo": (
        "#30123b #4040a2 #466be3 #4294ff #28bceb #18ddc2 #32f298 #6dfe62 #a4fc3c "
        "#cdec34 #eecf3a #fdac34 #fb7e21 #eb500e #d02f05 #a91601 #7a0403"
    ),
    "coolwarm": (
        "#3b4cc0 #4e68d8 #6282ea #779af7 #8db0fe #a3c2fe #b9d0f9 #ccd9ed #dddcdc "
        "#ecd3c5 #f5c4ac #f7b093 #f4987a #eb7d62 #dd5f4b #ca3b37 #b40426"
    ),
    "twilight": (
        "#e2d9e2 #c4ced4 #95b5c7 #7297c1 #6276ba #5e51ad #592a8f #45135c #2f1436 "
        "#4a1342 #741e4f #983550 #b25652 #c27c63 #cca389 #d8c7be #e2d9e2"
    ),
    "ice": "#02030f #0b2a5b #1663a8 #3fa3dc #8fd6f5 #d6f3ff #ffffff",
    "fire": "#120101 #5a0a04 #b32007 #f0540f #ff9a2b #ffd56b #fff6d8",
    "aurora": "#04061a #0c2f4f #0d6b6e #1fb57a #6df0a0 #8f9bff #d79bff",
}

GROUP_COLORS = ("#ffb454", "#5ccfe6", "#f07178", "#a6e06b", "#c49bff", "#ffe08a", "#6fa8ff", "#ff9ed1")
"""Colours of groups that have none of their own, in the order of the scene, then again from the start."""


def blend(colors: Sequence[str], count: int) -> NDArray[np.float64]:
    """Colours blended evenly from the first to the last, in Oklab; linear sRGB, shape (count, 3).

    Args:
        colors: two or more, as #rrggbb.
        count: how many places, two or more; the first and last are the ends.
    """
    stops = to_oklab(from_hex(colors))
    places = np.linspace(0, len(stops) - 1, count)
    lab = np.stack([np.interp(places, np.arange(len(stops)), stops[:, axis]) for axis in range(3)], axis=-1)
    return np.maximum(from_oklab(lab), 0.0)


def colormap(colors: Palette | tuple[str, ...], count: int) -> NDArray[np.float64]:
    """A named palette or a list of colours at `count` even places; linear sRGB, shape (count, 3)."""
    return blend(PALETTES[colors].split() if isinstance(colors, str) else colors, count)

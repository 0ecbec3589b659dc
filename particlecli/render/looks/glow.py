"""Glow: a soft core with a halo that fades as distance^-2.5. Costs the same for every size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.render.canvas import Canvas
from particlecli.render.looks.base import Look


class Glow(Look):
    """Soft light; the core's standard deviation is half the radius."""

    halo = 0.35

    def draw(self, canvas: Canvas, count: int, colors: NDArray[np.float32]) -> None:
        """Add the sprites to the canvas's light."""
        tools = canvas.tools
        tools.soft.draw(tools.sprites, count, canvas.pyramid, colors, halo=self.halo)

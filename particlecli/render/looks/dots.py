"""Dots: crisp antialiased discs. Their cost grows with their area."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.render.canvas import Canvas
from particlecli.render.looks.base import Look


class Dots(Look):
    """Discs of the radius, or points of the right light where that is less than a pixel."""

    halo = 0.0

    def draw(self, canvas: Canvas, count: int, colors: NDArray[np.float32]) -> None:
        """Add the sprites to the canvas's light."""
        tools = canvas.tools
        tools.discs.draw(tools.sprites, count, canvas.pyramid, colors, halo=self.halo)

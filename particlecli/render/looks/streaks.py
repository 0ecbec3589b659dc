"""Streaks: soft light smeared along the path that a particle took while the shutter was open."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.render.canvas import Canvas
from particlecli.render.looks.base import Look


class Streaks(Look):
    """Light spread evenly from a particle back along its velocity, with the energy of a glow at rest."""

    halo = 0.2
    smeared = True

    def draw(self, canvas: Canvas, count: int, colors: NDArray[np.float32]) -> None:
        """Add the sprites to the canvas's light."""
        tools = canvas.tools
        tools.soft.draw(tools.sprites, count, canvas.pyramid, colors, halo=self.halo, smeared=True)

"""What a look is: how sprites become light."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from particlecli.render.canvas import Canvas


class Look(ABC):
    """Draws the sprites that a group's particles were projected to.

    Attributes:
        halo: share of the light that surrounds each particle as a halo, here and in mirrors.
        smeared: whether particles are smeared along their motion while the shutter is open.
    """

    halo: ClassVar[float]
    smeared: ClassVar[bool] = False

    @abstractmethod
    def draw(self, canvas: Canvas, count: int, colors: NDArray[np.float32]) -> None:
        """Add the first `count` sprites of the canvas's tools to its light; `colors` is the tint's table."""

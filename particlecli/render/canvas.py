"""Where looks draw: the pyramid that takes the light, and the rasters, each made when first used."""

from __future__ import annotations

from functools import cached_property

from particlecli.render.discs import DiscRaster
from particlecli.render.pyramid import Pyramid
from particlecli.render.soft import SoftRaster
from particlecli.render.sprites import POOLED, SEEN, Sprites


class Tools:
    """Rasters and sets of sprites, shared by all groups and pyramids of a renderer."""

    def __init__(self) -> None:
        self.sprites = Sprites(SEEN)
        self.pooled = Sprites(POOLED)

    @cached_property
    def soft(self) -> SoftRaster:
        """For soft light."""
        return SoftRaster()

    @cached_property
    def discs(self) -> DiscRaster:
        """For crisp discs."""
        return DiscRaster()


class Canvas:
    """A pyramid and the tools that draw into it."""

    def __init__(self, pyramid: Pyramid, tools: Tools) -> None:
        self.pyramid = pyramid
        self.tools = tools

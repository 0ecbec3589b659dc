"""Dots: crisp antialiased discs. Their cost grows with their area."""

from particlecli.render.looks.base import Look


class Dots(Look):
    """Discs of the radius, or points of the right light where that is less than a pixel."""

    halo = 0.0
    crisp = True

"""Glow: a soft core with a halo that fades as distance^-2.5. Costs the same for every size."""

from particlecli.render.looks.base import Look


class Glow(Look):
    """Soft light; the core's standard deviation is half the radius."""

    halo = 0.35

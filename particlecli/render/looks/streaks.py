"""Streaks: soft light smeared along the path that a particle took while the shutter was open."""

from particlecli.render.looks.base import Look


class Streaks(Look):
    """Light spread evenly from a particle back along its velocity, with the energy of a glow at rest."""

    halo = 0.2
    smeared = True

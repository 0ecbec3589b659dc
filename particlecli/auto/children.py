"""Births of children for pilots: a few of those that a sample of parents bears, about where they are when they bear."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from particlecli.auto.pilot import SAMPLE, Pilot
from particlecli.dynamics.birth_table import BirthTable
from particlecli.dynamics.births import EmitterBirths
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.kin import Brood, Parents
from particlecli.scene.integrator import UNCHOSEN

STEPS = 4
"""Equal steps a frame of the parents' flight."""


def children(brood: Brood, births: EmitterBirths, parents: Pilot) -> BirthTable | None:
    """Children of a pilot's particles; none where these live for less than a frame.

    Those that are born on a death start at the last frame of their parent, others at frames spread over its life.
    """
    flown = parents.fly(SCHEMES[UNCHOSEN], steps=STEPS).positions
    lives = (~np.isnan(flown[:, :, 0])).sum(axis=0)
    (bearing,) = np.nonzero(lives)
    if not len(bearing):
        return None
    each = max(1, min(brood.each, SAMPLE // len(bearing)))
    rows, places = np.repeat(bearing, each), np.tile(np.arange(each), len(bearing))
    last = lives[rows] - 1
    frames = last if brood.rule.on == "death" else last * (places + 1) // each
    before = np.where(frames[:, None] > 0, flown[frames - 1, rows], parents.origins[rows])
    positions = flown[frames, rows]
    return births.of_parents(
        brood,
        Parents(
            ids=parents.ids[rows],
            places=places,
            times=parents.births[rows] + (frames + 1) * parents.interval,
            positions=positions.T,
            velocities=(positions - before).T / parents.interval,
        ),
    )


def first_brood(broods: Sequence[Brood], pilots: dict[str, Pilot], child: str) -> Brood | None:
    """The first rule by which particles that are flown bear those of a group."""
    return next((brood for brood in broods if brood.child == child and brood.parent in pilots), None)

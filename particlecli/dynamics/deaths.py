"""Fates: what has become of a particle, and the causes of death."""

from enum import IntEnum

CAUSES = ("expired", "cold", "plane", "outside", "non_finite")
"""Causes of death as reports name them; the code of a cause is its place here plus one."""


class Fate(IntEnum):
    """The number kept with each particle of a group that can die or stick; positive numbers are deaths."""

    STUCK = -1
    ALIVE = 0
    EXPIRED = 1
    COLD = 2
    PLANE = 3
    OUTSIDE = 4
    NON_FINITE = 5

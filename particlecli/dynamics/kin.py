"""Parents and children: the numbers that children get, and where and when they are born."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.random import Array
from particlecli.scene.groups import Children


@dataclass(frozen=True)
class Brood:
    """What the particles of one group bear by one rule.

    A child's number, and with it all that is drawn for it, follows from its parent's: `first` + `each` × the
    parent's number + its place among its siblings.

    Attributes:
        parent, child: names of groups.
        rule: when and how many.
        first: the least number of these children.
        each: how many numbers are set aside for the children of each parent.
        total: how many numbers are set aside in all.
    """

    parent: str
    child: str
    rule: Children
    first: int
    each: int
    total: int

    def numbers(self, parents: NDArray[np.int64], places: NDArray[np.int64]) -> NDArray[np.int64]:
        """Numbers of children, by the numbers of their parents and their places among siblings; all shape (n,)."""
        return self.first + self.each * parents + places


@dataclass(frozen=True)
class Parents:
    """Particles at the instants at which they bear.

    Attributes:
        ids: shape (n,), their numbers.
        places: shape (n,), place of the child among its siblings, or of the first of several.
        times: shape (n,), s.
        positions, velocities: shape (3, n), m and m/s.
    """

    ids: NDArray[np.int64]
    places: NDArray[np.int64]
    times: Array
    positions: Array
    velocities: Array

"""Newborn particles in order of birth, column by column, and what a scene's values make of a column."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.random import Array, Draw, Draws, sample
from particlecli.scene.distributions import Distribution
from particlecli.scene.groups import Group
from particlecli.scene.poses import Poses


@dataclass(frozen=True)
class BirthTable:
    """Newborn particles of one group in order of birth.

    What is None is either no part of the group or the same for all its particles and told by the scene.

    Attributes:
        ids: shape (n,), birth indices.
        times: shape (n,), s.
        positions: shape (3, n), m.
        velocities: shape (3, n), m/s; None in a first-order group.
        masses: shape (n,), kg; None where all are equal.
        lifetimes: shape (n,), s; None where particles live on.
        temperatures: shape (n,), K; None where the group has no temperature.
        cooling_rates: shape (n,), 1/s; None where all are equal or nothing cools at a rate.
    """

    ids: NDArray[np.int64]
    times: Array
    positions: Array
    velocities: Array | None = None
    masses: Array | None = None
    lifetimes: Array | None = None
    temperatures: Array | None = None
    cooling_rates: Array | None = None

    def __len__(self) -> int:
        return len(self.ids)

    def rows(self, places: NDArray[np.int64]) -> BirthTable:
        """The rows at these places, in their order."""
        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(self, **{name: column[..., places] for name, column in columns.items() if column is not None})


def placed(poses: Poses, group: Group, positions: Array, velocities: Array | None) -> tuple[Array, Array | None]:
    """Positions and velocities in the world of what is given in a frame; both of shape (3, n)."""
    if velocities is not None:
        velocities = poses.directions(velocities) + group.inherit_velocity * poses.velocities(positions)
    return poses.points(positions), velocities


def present(value: float | Distribution | None, draws: Draws, draw: Draw) -> Array | None:
    """A number of each particle, shape (n,); None where the scene gives none."""
    return None if value is None else sample(value, draws, draw)


def differing(value: float | Distribution | None, draws: Draws, draw: Draw) -> Array | None:
    """A number of each particle, shape (n,); None where it is the same for all, or there is none."""
    return sample(value, draws, draw) if isinstance(value, Distribution) else None


def cooling_rates(group: Group, draws: Draws) -> Array | None:
    """The rate of Newton's cooling of each particle, 1/s, as of `differing`."""
    return None if group.cooling is None else differing(group.cooling.rate, draws, Draw.COOLING_RATE)

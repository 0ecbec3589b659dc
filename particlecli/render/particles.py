"""A group's particles as kernels take them: rows of 32-bit floats."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import GroupFrame
from particlecli.render.sprites import FEW, MANY, PACK
from particlecli.render.tint import Tint

Floats = NDArray[np.float32]

NO_QUANTITY, GIVEN, LIFE_SHARE, SPEED = range(4)
"""Where the quantity that a tint looks up comes from."""

_ABSENT: Floats = np.zeros(1, np.float32)
_ABSENT_VECTORS: Floats = np.zeros((3, 1), np.float32)


@dataclass(frozen=True)
class Particles:
    """Particles of one group.

    Attributes:
        count: how many.
        positions, velocities: shape (3, count).
        quantity: shape (count,), what the tint looks up.
        ages, lifetimes: shape (count,).
        ids: shape (count,), int64.
        relative: whether positions are relative to the camera.
        has_ages, has_lifetimes: whether the group ages, and whether it dies of age.

    Where something does not exist or is not needed, one element stands for it.
    """

    count: int
    positions: Floats
    velocities: Floats
    quantity: Floats
    ages: Floats
    lifetimes: Floats
    ids: NDArray[np.int64]
    relative: bool
    has_ages: bool
    has_lifetimes: bool

    @classmethod
    def of(cls, group: GroupFrame, tint: Tint, camera: NDArray[np.float64], *, moving: bool) -> Particles:
        """The particles of a group.

        Args:
            group: one group of a frame.
            tint: says which quantity is looked up.
            camera: position of the camera, m; positions in double precision are made relative to it.
            moving: whether velocities are needed though the tint does not need them.

        Raises:
            ValueError: the frame lacks a field that the look needs.
        """
        relative = group.positions.dtype == np.float64
        positions = group.positions.T - camera[:, None] if relative else group.positions.T
        velocities = _ABSENT_VECTORS
        if moving or tint.quantity == "speed":
            velocities = _single(_present(group.velocities, "velocities").T)
        return cls(
            count=len(group),
            positions=_single(positions),
            velocities=velocities,
            quantity=_quantity(group, tint),
            ages=_ABSENT if group.ages is None else _single(group.ages),
            lifetimes=_ABSENT if group.lifetimes is None else _single(group.lifetimes),
            ids=group.ids,
            relative=relative,
            has_ages=group.ages is not None,
            has_lifetimes=group.ages is not None and group.lifetimes is not None,
        )

    @property
    def arrays(self) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """All but the ids, in the order in which kernels take them."""
        return self.positions, self.velocities, self.quantity, self.ages, self.lifetimes

    def source(self, tint: Tint) -> int:
        """Where kernels find the quantity that a tint looks up."""
        match tint.quantity:
            case "none":
                return NO_QUANTITY
            case "age":
                return LIFE_SHARE if self.has_lifetimes else GIVEN
            case "speed":
                return SPEED
            case _:
                return GIVEN

    def batches(self, *, smeared: bool = False) -> Iterator[tuple[int, int]]:
        """First place and number of particles that are drawn at once; of smeared ones each takes many records."""
        most = FEW if smeared else MANY
        for first in range(0, self.count, most):
            yield first, min(most, self.count - first)


def room_of(groups: Iterable[Particles]) -> int:
    """Places that the sprites of all particles of some groups take, whole packs for each group."""
    return sum(particles.count + -particles.count % PACK for particles in groups)


def _single(values: NDArray[np.floating[Any]]) -> Floats:
    return np.ascontiguousarray(values, dtype=np.float32)


def _present(field: NDArray[np.floating[Any]] | None, name: str) -> NDArray[np.floating[Any]]:
    if field is None:
        raise ValueError(f"the look of this group needs {name}, which the frame does not have")
    return field


def _quantity(group: GroupFrame, tint: Tint) -> Floats:
    """The quantity of the tint where kernels cannot compute it from the other rows."""
    match tint.quantity:
        case "temperature":
            return _single(_present(group.temperatures, "temperatures"))
        case "age" if group.lifetimes is None:
            return _single(_present(group.ages, "ages"))
        case "id":
            return _single(group.ids.astype(np.float64))
        case _:
            return _ABSENT

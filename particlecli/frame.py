"""Frame: the only thing that crosses from the dynamics to the renderer and the sinks. Plain NumPy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True)
class GroupFrame:
    """The living particles of one group at one instant, in order of birth.

    Attributes:
        ids: shape (n,), int64; the birth index of each particle within its group, never reused.
        positions: shape (n, 3), m. Stored component by component: `positions.T` is C-contiguous.
        velocities: shape (n, 3), m/s; None for a first-order group, which has none, or when not asked for.
        ages: shape (n,), s since birth; None where the group does not age.
        lifetimes: shape (n,), s; None where particles live on.
        temperatures: shape (n,), K; None where the group has no temperature.
    """

    ids: NDArray[np.int64]
    positions: Floats
    velocities: Floats | None = None
    ages: Floats | None = None
    lifetimes: Floats | None = None
    temperatures: Floats | None = None

    def __len__(self) -> int:
        return len(self.ids)


@dataclass(frozen=True)
class Curve:
    """A number at some of the frames.

    Attributes:
        frames, times, values: of the same length; times in s.
    """

    frames: tuple[int, ...]
    times: tuple[float, ...]
    values: tuple[float, ...]


@dataclass(frozen=True)
class Frame:
    """The state of all groups at one instant.

    Attributes:
        index: number of the frame, from 0 at t = 0.
        time: s.
        groups: the groups in the order of the scene, by name; a group without living particles is there, empty.
        series: numbers about the whole at this instant, by plot and name, such as `energy`, `kinetic`; empty
            unless an output asks for them.
        springs: by group, the ids of the particles that whole springs join, shape (n, 2); likewise.
    """

    index: int
    time: float
    groups: Mapping[str, GroupFrame]
    series: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    springs: Mapping[str, NDArray[np.int64]] = field(default_factory=dict)

    @property
    def alive(self) -> int:
        """How many particles are alive in all groups together."""
        return sum(len(group) for group in self.groups.values())

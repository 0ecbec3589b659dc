"""What a look of bodies is: how a group's particles become bodies that are sorted by depth and drawn."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import GroupFrame
from particlecli.render.camera import View
from particlecli.render.solids.light import Lighting
from particlecli.render.solids.records import Records
from particlecli.render.tint import Tint
from particlecli.scene.groups import Emitter, Particles
from particlecli.scene.look import GroupLook

Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Subject:
    """A group that is drawn as bodies.

    Attributes:
        name: of the group.
        group, style: what the scene says of it.
        tint: its colours.
        light: what falls on it.
        folder: the scene's.
        largest: radius that nothing exceeds, pixels.
    """

    name: str
    group: Particles | Emitter
    style: GroupLook
    tint: Tint
    light: Lighting
    folder: Path
    largest: float

    @property
    def colors(self) -> Floats:
        """The tint's table, as bright as the group."""
        return (self.style.brightness * self.tint.table).astype(np.float32)

    @property
    def fades(self) -> bool:
        """Whether its particles fade."""
        return self.style.fade_in > 0 or self.style.fade_out > 0


class Body(ABC):
    """Makes bodies of the particles of one group.

    Attributes:
        kind: of body, see `layer_kernels`.
        place: in the table of looks.
        planes, hiding: (normal, height of the camera), of which the first `hiding` hide what is behind them.
    """

    kind: ClassVar[int]
    place: int = 0
    planes: Floats
    hiding: int

    def __init__(self, subject: Subject) -> None:
        self.subject = subject

    @property
    def needs(self) -> frozenset[str]:
        """Fields of a frame that this group's look is computed from."""
        return self.subject.tint.needs | frozenset({"ages", "lifetimes"} if self.subject.fades else ())

    def sheet(self) -> tuple[Floats, int]:
        """Texels of its own sheet, shape (texels, 4), and across a picture; by default none."""
        return np.zeros((0, 4), np.float32), 0

    @abstractmethod
    def aim(self, view: View) -> Floats:
        """Take a camera's view; returns the cap for it, shape (texels, 8), of no texels where there is none."""

    @abstractmethod
    def room(self, group: GroupFrame) -> int:
        """How many bodies a group needs at most."""

    @abstractmethod
    def put(self, group: GroupFrame, records: Records) -> None:
        """Add a group's bodies."""

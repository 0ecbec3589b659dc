"""Looks that show each particle by a picture that faces the camera: spheres and sprites."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import GroupFrame
from particlecli.render.camera import View
from particlecli.render.looks.body import Body, Subject
from particlecli.render.particles import Particles
from particlecli.render.shot import lens_row, paint_of
from particlecli.render.solids.billboard_kernels import put_billboards
from particlecli.render.solids.caps import TEXELS, cap
from particlecli.render.solids.layer_kernels import BILLBOARDS
from particlecli.render.solids.records import Records
from particlecli.render.solids.sheets import load_sheet

Floats = NDArray[np.float32]

SQUARE = 4 / math.pi
"""A square is so much larger than the disc in it."""


class Billboards(Body):
    """One picture for each particle.

    Attributes:
        spread: how far a picture reaches, radii.
        pictures: how many there are.
        small: pictures of a smaller radius, pixels, have one colour.
    """

    kind = BILLBOARDS
    spread = 1.0
    pictures = 1
    small: ClassVar[float]
    _means: Floats
    _hides: float

    def __init__(self, subject: Subject) -> None:
        super().__init__(subject)
        self._colors = subject.colors

    def aim(self, view: View) -> Floats:
        """Take a camera's view."""
        style = self.subject.style.model_copy(update={"brightness": 1.0})
        paint = paint_of(style, self.subject.tint, view)
        self._position = view.position
        self._shots = [np.concatenate([lens_row(view, at, self.subject.largest), paint]) for at in self._origins]
        return np.zeros((0, 8), np.float32)

    @property
    def _origins(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return self._position, np.zeros(3)

    def room(self, group: GroupFrame) -> int:
        """As many as there are particles."""
        return len(group)

    def put(self, group: GroupFrame, records: Records) -> None:
        """Add a group's particles."""
        tint, style = self.subject.tint, self.subject.style
        particles = Particles.of(group, tint, self._position, moving=False)
        aged = particles.has_lifetimes and self.pictures > 1
        put_billboards(
            records.take(particles.count), particles.count, *particles.arrays, particles.ids,
            self._shots[particles.relative], self.planes, self.hiding, self._colors, records.heads,
            records.rows, particles.source(tint), self.subject.fades and particles.has_lifetimes, aged, self.place,
            float(self.pictures), style.sheet_rate or 0.0, style.spin or 0.0, style.spin is not None, self.spread,
            self.small, self._means, self._hides,
        )  # fmt: skip


class Spheres(Billboards):
    """Lit balls, matt or clear, with a highlight and a rim that mirrors the surroundings."""

    small = 1.6

    def aim(self, view: View) -> Floats:
        """Take a camera's view."""
        super().aim(view)
        texels = cap(view, self.subject.light, self.subject.style.opacity)
        self._means, self._hides = texels[-1:], 1.0
        return texels

    def sheet(self) -> tuple[Floats, int]:
        """No sheet, but the size of a cap."""
        return np.zeros((0, 4), np.float32), TEXELS


class Sprites(Billboards):
    """Pictures of a sheet, by age."""

    small = 2.2

    def __init__(self, subject: Subject) -> None:
        super().__init__(subject)
        self.spread = 1.0 if subject.style.spin is None else math.sqrt(2.0)
        style, key = subject.style, f"look.groups.{subject.name}.sheet"
        self._texels, self._size, self.pictures = load_sheet(
            style.sheet or "smoke", style.grid or (1, 1), subject.folder, key
        )
        coarsest = self._texels.reshape(self.pictures, -1, 4)[:, -1] * np.float32(SQUARE)
        self._means = np.ascontiguousarray(np.pad(coarsest, ((0, 0), (0, 4))))
        self._hides = style.opacity

    def sheet(self) -> tuple[Floats, int]:
        """Its pictures."""
        return self._texels, self._size

    @property
    def needs(self) -> frozenset[str]:
        """Pictures follow the age, and so do turns."""
        style, group = self.subject.style, self.subject.group
        ageing = (self.pictures > 1 and group.lifetime is not None) or bool(style.spin or style.sheet_rate)
        return super().needs | frozenset({"ages", "lifetimes"} if ageing else ())

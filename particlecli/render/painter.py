"""How one group is painted: from its particles to sprites of a picture, of a mirror and of light on the ground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import GroupFrame
from particlecli.render.batch import Batch
from particlecli.render.camera import View
from particlecli.render.looks.base import Look
from particlecli.render.particles import Particles
from particlecli.render.project import project
from particlecli.render.reflect import reflect
from particlecli.render.shot import lens_row, paint_of
from particlecli.render.solids.layer import Layer
from particlecli.render.sprites import POOLED, SEEN, Span
from particlecli.render.tasks import CHUNK
from particlecli.render.tint import Tint
from particlecli.scene.look import GroupLook

Floats = NDArray[np.float32]

MIRRORED_AT_MOST = 1 << 18
POOLED_AT_MOST = 1 << 15
"""Of larger groups some particles, chosen by id, are mirrored or light the ground for all of them."""


class Painter:
    """Paints one group."""

    def __init__(self, style: GroupLook, look: Look, tint: Tint, colors: int, interval: float, largest: float) -> None:
        """Prepares to paint.

        Args:
            style: of the group.
            look: how sprites become light.
            tint: its colours.
            colors: where they begin in the table of all tints.
            interval: time between frames, s.
            largest: radius that no particle exceeds, pixels.
        """
        self.look = look
        self.tint = tint
        self._colors = colors
        self.fades = style.fade_in > 0 or style.fade_out > 0
        self._style, self._interval, self._largest = style, interval, largest

    def aim(self, view: View) -> None:
        """Take a camera's view; before all else."""
        paint = paint_of(self._style, self.tint, view, self._interval)
        self._view = view
        self._absolute = np.concatenate([lens_row(view, view.position, self._largest), paint])
        self._relative = np.concatenate([lens_row(view, np.zeros(3), self._largest), paint])

    @property
    def needs(self) -> frozenset[str]:
        """Fields of a frame that this group's look is computed from."""
        fading = frozenset({"ages", "lifetimes"}) if self.fades else frozenset()
        moving = frozenset({"velocities", "ages"}) if self.look.smeared else frozenset()
        return self.tint.needs | fading | moving

    def particles(self, group: GroupFrame) -> Particles:
        """The group's particles for kernels."""
        return Particles.of(group, self.tint, self._view.position, moving=self.look.smeared)

    def draw(
        self, particles: Particles, batch: Batch, planes: Floats, hiding: int, bodies: Layer | None = None
    ) -> None:  # fmt: skip
        """Put the particles' sprites in a batch; bodies and the first `hiding` planes (normal, height) hide them."""
        look = self.look
        for first, count in particles.batches(smeared=look.smeared):
            place = batch.take(count)
            project(
                first, count, *particles.arrays, self._shot(particles), planes, batch.store.sprites, place,
                *self._source(particles), *self._smear(particles), hiding, count <= CHUNK,
            )  # fmt: skip
            if bodies:
                bodies.hide(batch.store, place, first, count, particles, self._view)
            batch.add(SEEN, Span(place, place + count, self._colors, look.halo, look.smeared, look.crisp))

    def reflect(self, particles: Particles, batch: Batch, mirror: Floats, resolution: float, halo: float) -> None:
        """Put the particles' mirror images in a batch, and the light that they throw on the mirror.

        Args:
            particles: this group's.
            batch: takes what the mirror shows, with `resolution` pixels to a pixel of the picture, as SEEN, and the
                irradiance on the plane's grid as POOLED.
            mirror: the plane.
            resolution: see `batch`.
            halo: share of the irradiance that falls far away.
        """
        shot = np.concatenate([self._shot(particles), mirror])
        one_in = -(-particles.count // MIRRORED_AT_MOST), -(-particles.count // POOLED_AT_MOST)
        for first, count in particles.batches(smeared=self.look.smeared):
            place = batch.take(count)
            reflect(
                first, count, *particles.arrays, particles.ids, shot, batch.store.sprites,
                *one_in, resolution, place, *self._source(particles), *self._smear(particles), count <= CHUNK,
            )  # fmt: skip
            batch.add(SEEN, Span(place, place + count, self._colors, self.look.halo, self.look.smeared))
            batch.add(POOLED, Span(place, place + count, self._colors, halo))

    def _shot(self, particles: Particles) -> Floats:
        return self._relative if particles.relative else self._absolute

    def _source(self, particles: Particles) -> tuple[int, bool]:
        """Where the tint's quantity comes from, and whether particles fade."""
        fading = self.fades and particles.has_lifetimes
        return particles.source(self.tint), fading

    def _smear(self, particles: Particles) -> tuple[bool, bool]:
        """Whether particles are smeared not beyond their birth, and whether they are smeared."""
        return self.look.smeared and particles.has_ages, self.look.smeared

"""How one group is painted: from its particles to light on a canvas, in mirrors and on the ground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import GroupFrame
from particlecli.render.camera import View
from particlecli.render.canvas import Canvas
from particlecli.render.looks.base import Look
from particlecli.render.particles import Particles
from particlecli.render.project import project
from particlecli.render.reflect import reflect
from particlecli.render.shot import lens_row, paint_of
from particlecli.render.solids.layer import Layer
from particlecli.render.tint import Tint
from particlecli.scene.look import GroupLook

Floats = NDArray[np.float32]

MIRRORED_AT_MOST = 1 << 18
POOLED_AT_MOST = 1 << 15
"""Of larger groups some particles, chosen by id, are mirrored or light the ground for all of them."""


class Painter:
    """Paints one group."""

    def __init__(self, style: GroupLook, look: Look, tint: Tint, interval: float, largest: float) -> None:
        """`interval` is the time between frames, s; `largest` the radius that no particle exceeds, pixels."""
        self.look = look
        self.tint = tint
        self.fades = style.fade_in > 0 or style.fade_out > 0
        self._counter = np.zeros(1, np.int32)
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
        self, particles: Particles, canvas: Canvas, planes: Floats, hiding: int, bodies: Layer | None = None
    ) -> None:  # fmt: skip
        """Add the particles' light; bodies and the first `hiding` planes (normal, height) hide what is behind them."""
        sprites = canvas.tools.sprites
        for first, count in particles.batches(smeared=self.look.smeared):
            sprites.reserve(count)
            project(
                first, count, *particles.arrays, self._shot(particles), planes, self._counter, sprites.store.sprites,
                *self._source(particles), *self._smear(particles), hiding,
            )  # fmt: skip
            if bodies:
                bodies.hide(sprites, first, count, particles, self._view)
            self.look.draw(canvas, count, self.tint.table)

    def reflect(
        self, particles: Particles, seen: Canvas, pool: Canvas, mirror: Floats, resolution: float, halo: float
    ) -> None:
        """Add the light of the particles' mirror images, and a plane's irradiance by them.

        Args:
            particles: this group's.
            seen: takes what the mirror shows; it has `resolution` pixels to a pixel of the picture.
            pool: takes the irradiance, on the plane's grid.
            mirror: the plane.
            resolution: see `seen`.
            halo: share of the irradiance that falls far away.
        """
        shot = np.concatenate([self._shot(particles), mirror])
        one_in = -(-particles.count // MIRRORED_AT_MOST), -(-particles.count // POOLED_AT_MOST)
        mirrored, pooled = seen.tools.sprites, pool.tools.pooled
        for first, count in particles.batches(smeared=self.look.smeared):
            mirrored.reserve(count)
            pooled.reserve(count)
            reflect(
                first, count, *particles.arrays, particles.ids, shot, self._counter, mirrored.store.sprites,
                *one_in, resolution, *self._source(particles), *self._smear(particles),
            )  # fmt: skip
            seen.tools.soft.draw(
                mirrored, count, seen.pyramid, self.tint.table, halo=self.look.halo, smeared=self.look.smeared
            )
            pool.tools.soft.draw(pooled, count, pool.pyramid, self.tint.table, halo=halo)

    def _shot(self, particles: Particles) -> Floats:
        return self._relative if particles.relative else self._absolute

    def _source(self, particles: Particles) -> tuple[int, bool]:
        """Where the tint's quantity comes from, and whether particles fade."""
        fading = self.fades and particles.has_lifetimes
        return particles.source(self.tint), fading

    def _smear(self, particles: Particles) -> tuple[bool, bool]:
        """Whether particles are smeared not beyond their birth, and whether they are smeared."""
        return self.look.smeared and particles.has_ages, self.look.smeared

"""Shadows of particles on planes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import Frame
from particlecli.render.arrays import vec3
from particlecli.render.batch import Batch
from particlecli.render.camera import View
from particlecli.render.ground import Facing, mirror_of
from particlecli.render.particles import Particles, room_of
from particlecli.render.pyramid import Pyramid
from particlecli.render.shot import lens_row, paint_of
from particlecli.render.solids.shadow_kernels import cast, shade
from particlecli.render.sprites import POOLED, Span
from particlecli.render.tint import Tint
from particlecli.scene.look import GroupLook
from particlecli.scene.model import Scene
from particlecli.scene.shapes import GridLayout, HairLayout, LineLayout

Floats = NDArray[np.float32]

CELLS = 1024
"""Cells along each side of a plane's grid of shadows."""

CAST_AT_MOST = 1 << 17
"""Of larger groups some particles, chosen by id, cast shadows for all of them."""

_PLAIN = Tint("none", 0.0, 1.0, np.ones((1, 4), np.float32))


class Shadows:
    """The groups of a scene that cast shadows."""

    def __init__(self, scene: Scene, pyramid: Pyramid) -> None:
        """`pyramid` has CELLS × CELLS nodes for the shadows on one plane."""
        self._styles = {name: _caster(scene, name) for name in casters(scene)}
        self._ground, self._sun = scene.look.ground, vec3(*scene.look.light.direction)
        self._pyramid = pyramid

    def fall(self, frame: Frame, planes: list[Facing], view: View, cover: Floats) -> None:
        """Take from how much lit ground is seen of each pixel, shape (height, width or more), what is in shadow."""
        pyramid, rays = self._pyramid, view.rays().astype(np.float32)
        level = pyramid.levels[0]
        groups = {
            name: Particles.of(frame.groups[name], _PLAIN, view.position, moving=False) for name in self._styles
        }  # fmt: skip
        for plane in planes:
            row = mirror_of(plane, self._ground, view, CELLS)
            pyramid.clear()
            batch = Batch({POOLED: pyramid}, _PLAIN.table, room_of(groups.values()))
            for name, style in self._styles.items():
                self._cast(groups[name], style, row, view, batch)
            batch.draw()
            pyramid.collapse(onto=0)
            shade(
                pyramid.arena.light, level.origin, level.pitch, float(CELLS), row, rays,
                np.ascontiguousarray(plane.cover, np.float32), cover, view.width, view.height,
            )  # fmt: skip

    def _cast(self, particles: Particles, style: GroupLook, plane: Floats, view: View, batch: Batch) -> None:
        origin = np.zeros(3) if particles.relative else view.position
        shot = np.concatenate([lens_row(view, origin, math.inf), paint_of(style, _PLAIN, view), plane])
        fading = (style.fade_in > 0 or style.fade_out > 0) and particles.has_lifetimes
        one_in = max(1, -(-particles.count // CAST_AT_MOST))
        for first, count in particles.batches():
            place = batch.take(count)
            cast(
                first, count, particles.positions, particles.ages, particles.lifetimes, particles.ids, shot, self._sun,
                batch.store.sprites, place, one_in, fading,
            )  # fmt: skip
            batch.add(POOLED, Span(place, place + count, 0, halo=0.0))


def casters(scene: Scene) -> list[str]:
    """The groups that cast shadows on planes that are drawn."""
    shown = bool(scene.planes) and scene.look.ground.visible
    looks = scene.look.groups
    return [name for name in scene.groups if shown and name in looks and looks[name].shadow > 0]


def _caster(scene: Scene, name: str) -> GroupLook:
    """The look of a group with the optical depth of its shadows as brightness.

    Particles of a skin touch each other; those of a ribbon have its area, width times distance.
    """
    style, group = scene.look.groups[name], scene.groups[name]
    depth = -math.log(max(1.0 - style.shadow, 0.02))
    layout = getattr(group, "layout", None)
    radius = style.radius
    if style.as_ == "surface" and isinstance(layout, GridLayout):
        spacing = layout.spacing if isinstance(layout.spacing, tuple) else (layout.spacing,) * 3
        radius = 0.6 * max(spacing)
    elif style.as_ == "ribbons" and radius is not None and isinstance(layout, (HairLayout, LineLayout)):
        length = layout.length if isinstance(layout, HairLayout) else math.dist(layout.start, layout.end)
        radius = math.sqrt(2 * radius * length / (layout.count - 1) / math.pi)
    return style.model_copy(update={"brightness": depth, "radius": radius})

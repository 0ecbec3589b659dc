"""What looks share that join the particles of a layout."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import GroupFrame
from particlecli.render.camera import View
from particlecli.render.looks.body import Body, Subject
from particlecli.render.points import quantity_of
from particlecli.render.shot import NEAREST

Floats = NDArray[np.float32]
Doubles = NDArray[np.float64]


class Strips(Body):
    """Where particles are on the picture, and their colours."""

    def __init__(self, subject: Subject) -> None:
        super().__init__(subject)
        self._colors = subject.colors[:, :3].astype(np.float64)

    def aim(self, view: View) -> Floats:
        """Take a camera's view."""
        self._view = view
        return np.zeros((0, 8), np.float32)

    def _all(self, group: GroupFrame, total: int) -> tuple[Doubles, Doubles]:
        """Places, m, and colours of all particles by id, each shape (total, 3); NaN of those that are gone."""
        places, colors = np.full((total, 3), np.nan), np.zeros((total, 3))
        places[group.ids] = group.positions
        quantity = quantity_of(group, self.subject.tint)
        if quantity is None:
            colors[:] = self._colors[0]
        else:
            tint = self.subject.tint
            share = (np.nan_to_num(quantity) - tint.low) * (tint.last / (tint.high - tint.low))
            colors[group.ids] = self._colors[np.clip(share, 0, tint.last).astype(np.int64)]
        return places, colors

    def _projected(self, places: Doubles) -> tuple[Doubles, Doubles]:
        """Pixels, shape (…, 2), and depths, shape (…), m; NaN of what is not before the camera."""
        pixels, depth = self._view.project(places.reshape(-1, 3))
        depth = np.where(depth > NEAREST * self._view.distance, depth, np.nan)
        return pixels.reshape(*places.shape[:-1], 2), depth.reshape(places.shape[:-1])

    def _above(self, places: Doubles, size: Doubles) -> Doubles:
        """Share of what is `size` long, m, that hiding planes let be seen: all above them, none a length below."""
        share = np.ones(places.shape[:-1])
        for plane in self.planes[: self.hiding].astype(np.float64):
            height = plane[3] + (places - self._view.position) @ plane[:3]
            share = np.minimum(share, np.clip(1.0 + height / np.maximum(size, 1e-12), 0.0, 1.0))
        return share

    def _unit(self, vectors: Doubles) -> Doubles:
        return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))

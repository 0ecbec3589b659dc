"""Surfaces: a skin over the particles of a grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import GroupFrame
from particlecli.render.looks.body import Subject
from particlecli.render.looks.strips import Doubles, Floats, Strips
from particlecli.render.solids.layer_kernels import TRIANGLES
from particlecli.render.solids.records import CORNERS, DEPTH, EDGES, EXTENT, FIRST_X, OPACITY, Records, X
from particlecli.scene.groups import Particles
from particlecli.scene.shapes import GridLayout

CLOTH_SHEEN = 0.25
"""Light from the surroundings that cloth seen from the side throws back."""


class Surface(Strips):
    """A skin over a grid, lit on both sides: of cloth its sheet, of a block its six faces."""

    kind = TRIANGLES

    def __init__(self, subject: Subject) -> None:
        super().__init__(subject)
        assert isinstance(subject.group, Particles)
        assert isinstance(subject.group.layout, GridLayout)
        across, up, deep = subject.group.layout.counts
        self._total = across * up * deep
        self._sheets = _sheets(np.arange(self._total).reshape(deep, up, across))

    def room(self, group: GroupFrame) -> int:  # noqa: ARG002 - the layout tells
        """Two triangles for each cell."""
        return sum(2 * (sheet.shape[0] - 1) * (sheet.shape[1] - 1) for sheet in self._sheets)

    def put(self, group: GroupFrame, records: Records) -> None:
        """Add the triangles."""
        places, colors = self._all(group, self._total)
        for sheet in self._sheets:
            self._put_sheet(places[sheet], colors[sheet], records)

    def _put_sheet(self, places: Doubles, colors: Doubles, records: Records) -> None:
        pixels, depth = self._projected(places)
        light = self._lit(places, colors)
        corners = (
            (np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[:-1, 1:]),
            (np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:]),
        )
        areas = [_area(*(pixels[corner] for corner in three)) for three in corners]
        for three, edges in zip(corners, _outlines(*areas), strict=True):
            rows = self._put_triangles([(pixels[c], depth[c], light[c]) for c in three], edges, records)
            if self.hiding:
                middles = np.mean([places[c] for c in three], axis=0)
                sizes = np.linalg.norm(places[three[0]] - middles, axis=-1)
                rows[:, OPACITY] *= self._above(middles, sizes).ravel()

    def _put_triangles(
        self, corners: list[tuple[Doubles, Doubles, Doubles]], edges: NDArray[np.int64], records: Records
    ) -> Floats:  # fmt: skip
        middle = np.mean([pixels for pixels, _, _ in corners], axis=0)
        depth = np.mean([each for _, each, _ in corners], axis=0).ravel()
        heads, rows = records.add(depth.size, self.place)
        reach = np.max([np.linalg.norm(pixels - middle, axis=-1) for pixels, _, _ in corners], axis=0).ravel()
        heads[:, X : X + 2], heads[:, DEPTH] = middle.reshape(-1, 2), depth
        heads[:, EXTENT] = np.where(np.isnan(depth), 0.0, reach + 1.5)
        for k in range(2):
            rows[:, FIRST_X + 2 * k : FIRST_X + 2 * k + 2] = (corners[k][0] - middle).reshape(-1, 2)
        for k in range(3):
            rows[:, CORNERS + 3 * k : CORNERS + 3 * k + 3] = corners[k][2].reshape(-1, 3)
        rows[:, EDGES], rows[:, OPACITY] = edges.ravel(), self.subject.style.opacity
        return rows

    def _lit(self, places: Doubles, colors: Doubles) -> Doubles:
        light = self.subject.light
        normals = self._unit(np.cross(np.gradient(places, axis=0), np.gradient(places, axis=1)))
        sight = np.nan_to_num(self._unit(self._view.position - places)) if self._view.slope else -self._view.forward
        normals = np.where(np.isnan(normals), sight, normals)  # beside what is gone
        facing = np.nan_to_num(np.sum(normals * sight, axis=-1))
        normals = normals * np.where(facing < 0, -1.0, 1.0)[..., None]
        sheen = CLOTH_SHEEN * (1.0 - np.abs(facing)) ** 3
        return np.asarray(colors * (light.on(normals) + sheen[..., None] * (light.sky + light.lamp)))


def _sheets(indices: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Grids of the particles that make up the skin of a grid of particles."""
    thin = [axis for axis in range(3) if indices.shape[axis] == 1]
    if thin:
        return [indices.squeeze(thin[0])]
    return [np.asarray(indices.take(end, axis)) for axis in range(3) for end in (0, -1)]


def _area(a: Doubles, b: Doubles, c: Doubles) -> Doubles:
    """Twice the signed areas of triangles on the picture, pixels²."""
    u, v = b - a, c - a
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])


def _outlines(first: Doubles, second: Doubles) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which edges of the two triangles of each cell have no neighbour that is seen from the same side: 1 + 2 + 4.

    Edges run from the first to the second corner, on to the third and back; both triangles share the diagonal.
    """
    one, two = np.sign(first), np.sign(second)
    before, above = np.zeros_like(two), np.zeros_like(two)
    before[:, 1:], above[1:] = two[:, :-1], two[:-1]
    after, below = np.zeros_like(one), np.zeros_like(one)
    after[:, :-1], below[:-1] = one[:, 1:], one[1:]
    return (
        (one != before) * 1 + (one != two) * 2 + (one != above) * 4,
        (two != below) * 1 + (two != after) * 2 + (two != one) * 4,
    )

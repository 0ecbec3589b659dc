"""Looks that join the particles of a layout: ribbons along ropes and hair, and the surface of grids."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import GroupFrame
from particlecli.render.camera import View
from particlecli.render.looks.body import Body, Subject
from particlecli.render.points import quantity_of
from particlecli.render.shot import LINES, NEAREST
from particlecli.render.solids.layer_kernels import PIECES, TRIANGLES
from particlecli.render.solids.records import (
    CORNERS,
    COVER,
    DEPTH,
    EDGES,
    END_X,
    EXTENT,
    FIRST_X,
    FROM_RED,
    HALF,
    OPACITY,
    TO_RED,
    Records,
    X,
)
from particlecli.scene.groups import Particles
from particlecli.scene.look import PLAIN_PIXELS
from particlecli.scene.shapes import GridLayout, HairLayout

Floats = NDArray[np.float32]
Doubles = NDArray[np.float64]

PARTS = 4
"""Straight pieces between two particles of a ribbon."""

FINE = 100_000
"""Ribbons of more particles are not smoothed."""

SHEEN, SHARPNESS = 0.35, 40.0
"""Strength and exponent of the highlight on ribbons."""

CLOTH_SHEEN = 0.25
"""Light from the surroundings that cloth seen from the side throws back."""


class Strips(Body):
    """What both looks share: where particles are on the picture, and their colours."""

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


class Ribbons(Strips):
    """Threads along the particles of a line, of strands of hair, or of a list, lit as hair is (Kajiya & Kay 1989)."""

    kind = PIECES

    def __init__(self, subject: Subject) -> None:
        super().__init__(subject)
        group = subject.group
        assert isinstance(group, Particles)
        layout = group.layout
        self._strands = layout.strands if isinstance(layout, HairLayout) else 1
        listed = len(group.positions or ())
        self._count = listed if layout is None else layout.count  # type: ignore[union-attr]
        self._parts = PARTS if self._strands * self._count <= FINE and self._count > 2 else 1

    def room(self, group: GroupFrame) -> int:  # noqa: ARG002 - the layout tells
        """A piece for each part."""
        return self._strands * (self._count - 1) * self._parts

    def put(self, group: GroupFrame, records: Records) -> None:
        """Add the pieces."""
        places, colors = (
            _smoothed(each.reshape(self._strands, self._count, 3), self._parts)
            for each in self._all(group, self._strands * self._count)
        )
        pixels, depth = self._projected(places)
        light = self._lit(places, colors)
        style, view = self.subject.style, self._view
        middle = 0.5 * (depth[:, 1:] + depth[:, :-1])
        half = np.full_like(middle, (style.pixels or PLAIN_PIXELS) * view.height / LINES)
        if style.radius is not None:
            half = style.radius * view.focal / (view.slope * middle + view.level)
        heads, rows = records.add(middle.size, self.place)
        seen = ~np.isnan(middle).ravel()
        along = 0.5 * (pixels[:, 1:] - pixels[:, :-1]).reshape(-1, 2)
        heads[:, X : X + 2] = (0.5 * (pixels[:, 1:] + pixels[:, :-1])).reshape(-1, 2)
        heads[:, DEPTH] = middle.ravel()
        rows[:, HALF], rows[:, COVER] = half.ravel(), style.opacity
        if self.hiding:
            middles, length = 0.5 * (places[:, 1:] + places[:, :-1]), np.linalg.norm(np.diff(places, axis=1), axis=-1)
            rows[:, COVER] *= self._above(middles, length).ravel()
        rows[:, END_X : END_X + 2] = along
        heads[:, EXTENT] = np.where(seen, np.linalg.norm(along, axis=1) + half.ravel() + 1.0, 0.0)
        rows[:, FROM_RED : FROM_RED + 3] = light[:, :-1].reshape(-1, 3)
        rows[:, TO_RED : TO_RED + 3] = light[:, 1:].reshape(-1, 3)

    def _lit(self, places: Doubles, colors: Doubles) -> Doubles:
        light = self.subject.light
        tangents = np.nan_to_num(self._unit(np.gradient(places, axis=1)))
        to_lamp = tangents @ light.direction
        to_eye = -(tangents @ self._view.forward)
        across = np.sqrt(np.maximum((1 - to_lamp**2) * (1 - to_eye**2), 0.0))
        shine = np.maximum(across - to_lamp * to_eye, 0.0) ** SHARPNESS
        matt = np.sqrt(np.maximum(1 - to_lamp**2, 0.0))[..., None] * 0.75 * light.lamp + 0.8 * light.sky
        return np.asarray(colors * matt + SHEEN * shine[..., None] * light.lamp * (0.3 + 0.7 * colors))


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


def _smoothed(points: Doubles, parts: int) -> Doubles:
    """Points along Catmull-Rom splines through points, shape (strands, n, 3) to (strands, (n − 1) parts + 1, 3)."""
    if parts == 1:
        return points
    ends = [2 * points[:, :1] - points[:, 1:2], points, 2 * points[:, -1:] - points[:, -2:-1]]
    padded = np.concatenate(ends, axis=1)
    before, here, there, after = padded[:, :-3], padded[:, 1:-2], padded[:, 2:-1], padded[:, 3:]
    pieces = []
    for part in range(parts):
        t = part / parts
        slope, bend, twist = there - before, 2 * before - 5 * here + 4 * there - after, 3 * here - before - 3 * there
        pieces.append(here + 0.5 * t * (slope + t * (bend + t * (twist + after))))
    joined = np.stack(pieces, axis=2).reshape(len(points), -1, 3)
    return np.concatenate([joined, points[:, -1:]], axis=1)


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

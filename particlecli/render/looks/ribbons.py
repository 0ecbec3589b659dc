"""Ribbons: threads along the particles of ropes, of hair, or of a list."""

from __future__ import annotations

import numpy as np

from particlecli.frame import GroupFrame
from particlecli.render.looks.body import Subject
from particlecli.render.looks.strips import Doubles, Strips
from particlecli.render.shot import LINES
from particlecli.render.solids.layer_kernels import PIECES
from particlecli.render.solids.records import COVER, DEPTH, END_X, EXTENT, FROM_RED, HALF, TO_RED, Records, X
from particlecli.scene.groups import Particles
from particlecli.scene.look import PLAIN_PIXELS
from particlecli.scene.shapes import HairLayout

PARTS = 4
"""Straight pieces between two particles of a ribbon."""

FINE = 100_000
"""Ribbons of more particles are not smoothed."""

SHEEN, SHARPNESS = 0.35, 40.0
"""Strength and exponent of the highlight on ribbons."""


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

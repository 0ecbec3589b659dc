"""Remarks on levels of a plot, put where they cover nothing."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

Doubles = NDArray[np.float64]

SPOTS = (0.0, 1.0, 0.5)
"""Where a remark may stand along its level, in parts of the axes' width, the best first."""

CLOSE, FREE = 2.0, 5.0
"""Pixels between the points that stand for a line; and around a remark that are to be free, half a mark among them."""


class Notes:
    """Puts remarks over or under levels of axes, so that they cover as little as possible of what is drawn by then.

    Args:
        axes: with all curves and the names of curves, which are joined to them by lines.
        colour: of the remarks.
    """

    def __init__(self, axes: Axes, colour: str) -> None:
        self._axes, self._colour = axes, colour
        canvas = axes.figure.canvas
        assert isinstance(canvas, FigureCanvasAgg)
        self._renderer = canvas.get_renderer()
        lines = [axes.transData.transform(np.asarray(line.get_xydata())) for line in axes.lines]
        for name in axes.texts:
            if isinstance(name, Annotation):
                ends = axes.transData.transform(name.xy), axes.transAxes.transform(name.get_position())
                lines.append(np.array(ends))
        self._taken = np.concatenate([np.empty((0, 2)), *map(_points, lines)])

    def put(self, text: str, level: float, *, above: bool = True) -> None:
        """A remark on a level, in the axes' units; under it alone if not `above`."""
        options = [
            self._drawn(text, level, spot, high=high)
            for high in ((True, False) if above else (False,))
            for spot in SPOTS
        ]
        covered = [self._covered(each.get_window_extent(self._renderer)) for each in options]
        best = options[int(np.argmin(covered))]
        for each in options:
            if each is not best:
                each.remove()
        box = best.get_window_extent(self._renderer)
        self._taken = np.concatenate([self._taken, _points(box.corners()[[0, 1, 3, 2, 0]])])

    def _drawn(self, text: str, level: float, spot: float, *, high: bool) -> Annotation:
        side = {0.0: "left", 1.0: "right"}.get(spot, "center")
        return self._axes.annotate(
            text,
            (spot, level),
            ({"left": 4, "right": -4}.get(side, 0), 2.5 if high else -9.5),
            xycoords=self._axes.get_yaxis_transform(),
            textcoords="offset points",
            ha=side,
            color=self._colour,
            fontsize=7.5,
            zorder=4,
        )

    def _covered(self, box: Bbox) -> int:
        """How much of what is drawn a box covers; what is outside the axes counts as all."""
        inside = self._axes.get_window_extent(self._renderer)
        if box.y0 < inside.y0 or box.y1 > inside.y1:
            return len(self._taken) + 1
        x, y = self._taken.T
        across = (x > box.x0 - FREE) & (x < box.x1 + FREE)
        return int((across & (y > box.y0 - FREE) & (y < box.y1 + FREE)).sum())


def _points(corners: Doubles) -> Doubles:
    """Points close to each other along a line through corners, shape (n, 2), pixels."""
    corners = corners[np.isfinite(corners).all(axis=1)]
    parts = [corners[:1]]
    for start, end in pairwise(corners):
        count = int(np.hypot(*(end - start)) / CLOSE) + 1
        parts.append(start + (end - start) * np.linspace(0.0, 1.0, count + 1)[1:, None])
    return np.concatenate(parts)

"""The stability regions of integrators with the modes of a scene upon them, as one would put it into a paper."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from particlecli.accuracy.analysis import Analysis, Limit
from particlecli.accuracy.plot_style import GREY, INK, PALE, STYLE
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import Splitting
from particlecli.errors import OutputError
from particlecli.scene.integrator import Scheme
from particlecli.stability.growth import excess, growth
from particlecli.stability.modes import Complexes, Modes, kinds_of

REGION, EDGE = "#e3eef9", "#5b8fc7"
KIND_COLOURS = {"oscillation": "#d9730d", "decay": "#1a7f37", "growth": "#8c959f"}
UNSTABLE = "#cf222e"

LEFT, RIGHT, BOTTOM, TOP = -7.2, 2.4, -0.35, 6.6
"""Corners of each panel in the plane of hα; complex conjugates are folded up."""

SIDES, GAPS = (0.055, 0.985), (0.14, 0.32)
"""Sides of the panels in parts of the width, and gaps between them in parts of a panel."""

HEAD, FOOT = 1.15, 0.55
"""Space above and below the panels, inches."""

POINTS = 360
COLUMNS = 4
MOST_DOTS = 400


def plot_stability(analysis: Analysis, path: Path) -> None:
    """Draws a panel for each integrator that the scene could use and writes it in the format the ending says.

    Raises:
        OutputError: the file cannot be written.
    """
    with rc_context(STYLE):
        figure = draw(analysis)
        try:
            figure.savefig(path, dpi=200, metadata={"Date": None} if path.suffix == ".svg" else None)
        except OSError as error:
            raise OutputError(f"cannot write {path}: {error.strerror}") from error


def draw(analysis: Analysis) -> Figure:
    """The plot, 10 inches wide."""
    limits = analysis.limits
    rows = max(1, math.ceil(len(limits) / COLUMNS))
    width = 10.0 * (SIDES[1] - SIDES[0]) / (COLUMNS + (COLUMNS - 1) * GAPS[0])
    height = width * (TOP - BOTTOM) / (RIGHT - LEFT) * (rows + (rows - 1) * GAPS[1]) + HEAD + FOOT
    figure = Figure(figsize=(10.0, height))
    FigureCanvasAgg(figure)
    sides = {"left": SIDES[0], "right": SIDES[1], "bottom": FOOT / height, "top": 1.0 - HEAD / height}
    gaps = {"wspace": GAPS[0], "hspace": GAPS[1]}
    grid = figure.subplots(rows, COLUMNS, squeeze=False, gridspec_kw={**sides, **gaps})
    step, modes = analysis.step or 1.0 / analysis.scene.fps, _modes(analysis)
    for axes, (scheme, limit) in zip(grid.flat, limits.items(), strict=False):
        _panel(axes, scheme, limit, modes, step, own=scheme == analysis.scene.integrator.type)
    for number, axes in enumerate(grid.flat):
        axes.set_visible(number < len(limits))
        axes.tick_params(labelleft=number % COLUMNS == 0, labelbottom=number + COLUMNS >= len(limits))
    figure.supxlabel("Re hα", y=0.1 / height, fontsize=9)
    figure.supylabel("Im hα", x=0.008, fontsize=9)
    reach = np.abs(step * modes.rates)
    clipped = bool((np.abs(_within(step * modes.rates)) < 0.999 * reach).any())
    _title(figure, analysis, step, height, clipped=clipped)
    _legend(figure, analysis, height)
    return figure


def _modes(analysis: Analysis) -> Modes:
    """The modes of all groups, alike ones once."""
    parts = [group.modes.distinct(paired=True) for group in analysis.groups]
    joined = parts[0]
    for part in parts[1:]:
        joined = joined.joined(part)
    return joined.at(slice(0, None, max(1, len(joined.rates) // MOST_DOTS)))


def _panel(axes: Axes, scheme: Scheme, limit: Limit, modes: Modes, step: float, *, own: bool) -> None:
    x, y = np.meshgrid(np.linspace(LEFT, RIGHT, POINTS), np.linspace(BOTTOM, TOP, POINTS))
    factors = growth(SCHEMES[scheme], Modes.of_pairs(x + 1j * y), 1.0)
    axes.contourf(x, y, factors, levels=(0.0, 1.0 + 1e-9), colors=[REGION])
    axes.contour(x, y, factors, levels=(1.0 + 1e-9,), colors=[EDGE], linewidths=0.9)
    axes.axhline(0.0, color=PALE, linewidth=0.6, zorder=1)
    axes.axvline(0.0, color=PALE, linewidth=0.6, zorder=1)
    if limit.rate is not None and limit.step > 0.0:
        _mark_limit(axes, limit.rate * limit.step)
    _dots(axes, scheme, modes, step)
    axes.set(xlim=(LEFT, RIGHT), ylim=(BOTTOM, TOP), xticks=range(-6, 3, 2), yticks=range(0, 7, 2))
    axes.set_title(scheme, loc="left", fontsize=9, color=INK, fontweight="bold" if own else "normal", pad=4)
    axes.set_title(_limit_text(limit), loc="right", fontsize=8, color=INK if own else GREY, pad=4)
    for spine in axes.spines.values():
        spine.set(color=INK if own else PALE, linewidth=1.4 if own else 0.8)


def _mark_limit(axes: Axes, z: complex) -> None:
    """The way of the mode that limits the step, from the origin to where it becomes unstable."""
    x, y = z.real, abs(z.imag)
    axes.plot([0.0, x], [0.0, y], color=INK, linewidth=0.7, linestyle=(0, (2, 2)), zorder=3)
    axes.plot([x], [y], marker="o", markersize=4.5, markerfacecolor="none", markeredgecolor=INK, zorder=3)


def _dots(axes: Axes, scheme: Scheme, modes: Modes, step: float) -> None:
    z = _within(step * modes.rates)
    kinds = kinds_of(modes.rates)
    grows = modes.counting & (excess(SCHEMES[scheme], modes, step) > 1.0 + 1e-9)
    for kind, colour in KIND_COLOURS.items():
        shown = (kinds == kind) & ~grows
        axes.plot(z[shown].real, z[shown].imag, "o", markersize=2.6, color=colour, zorder=4, clip_on=False)
    axes.plot(z[grows].real, z[grows].imag, "x", markersize=4.2, color=UNSTABLE, zorder=5, clip_on=False)


def _within(z: Complexes) -> Complexes:
    """Points in the upper half plane, those outside of the panel moved to its edge, towards the origin."""
    z = z.real + 1j * np.abs(z.imag)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = [LEFT / z.real, RIGHT / z.real, TOP / z.imag]
    share = np.min([np.where(each > 0.0, each, np.inf) for each in shares], axis=0)
    return np.asarray(z * np.minimum(share, 1.0))


def _limit_text(limit: Limit) -> str:
    if math.isinf(limit.step):
        return "any step"
    return f"to {limit.step:.3g} s" if limit.step else "no step"


def _title(figure: Figure, analysis: Analysis, step: float, height: float, *, clipped: bool) -> None:
    title = analysis.scene.title or analysis.scene.name
    figure.text(SIDES[0], 1.0 - 0.27 / height, title, fontsize=12, fontweight="bold", color=INK)
    modes = f"Modes e^(αt) at t = {analysis.time:g} s with steps of h = {step:.3g} s"
    figure.text(
        SIDES[0],
        1.0 - 0.5 / height,
        f"{modes} upon the stability regions, and the longest stable step"
        + ("; modes beyond a frame are on its edge" if clipped else ""),
        fontsize=9,
        color=GREY,
    )


def _legend(figure: Figure, analysis: Analysis, height: float) -> None:
    split = any(isinstance(SCHEMES[scheme], Splitting) for scheme in analysis.limits)
    region = "stable" + (" (splittings: for pairs α, ᾱ)" if split else "")
    limit: dict[str, Any] = {"markersize": 5, "markerfacecolor": "none", "linewidth": 0.7, "linestyle": (0, (2, 2))}
    handles = [
        Patch(facecolor=REGION, edgecolor=EDGE, label=region),
        *(
            Line2D([], [], marker="o", markersize=4, linestyle="", color=colour, label=kind)
            for kind, colour in KIND_COLOURS.items()
        ),
        Line2D([], [], marker="x", markersize=5, linestyle="", color=UNSTABLE, label="unstable"),
        Line2D([], [], marker="o", color=INK, label="which limits the step, and where", **limit),
    ]
    figure.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(SIDES[0] - 0.008, 1.0 - 0.55 / height),
        ncols=len(handles),
        frameon=False,
        fontsize=8,
        handletextpad=0.5,
        columnspacing=1.6,
    )

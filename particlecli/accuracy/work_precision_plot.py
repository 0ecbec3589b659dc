"""The work–precision plot: error against time, as one would put it into a paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from particlecli.accuracy.curves import Key, WorkPrecision, curves
from particlecli.accuracy.plot_notes import Notes
from particlecli.accuracy.plot_style import GREY, PALE, STYLE, colour_of
from particlecli.accuracy.runs import Run

LEFT, RIGHT, NAMES = 0.085, 0.755, 0.787
"""Sides of the axes, and where the names of the curves begin, in parts of the figure's width."""

MANY = 50.0
"""Where times differ by more, powers of ten alone are written along the axis."""

LOST = 10.0
"""Runs that are further off than so many times what particles move are left out."""


def save_plot(study: WorkPrecision, paths: Sequence[Path]) -> None:
    """Draws the plot and writes it to files, each in the format that its ending says.

    Raises:
        OSError: a file cannot be written.
    """
    with rc_context(STYLE):
        figure = draw(study)
        for path in paths:
            metadata = {"Date": None} if path.suffix == ".svg" else None
            figure.savefig(path, dpi=200, metadata=metadata)


def draw(study: WorkPrecision) -> Figure:
    """The plot, 8 × 5.4 inches."""
    figure = Figure(figsize=(8.0, 5.4))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((LEFT, 0.1, RIGHT - LEFT, 0.765))
    shown = _shown(study)
    _set_up(axes, study, [run for curve in shown.values() for run in curve])
    _mark_front(axes, study)
    for key, curve in shown.items():
        _draw_curve(axes, key, curve, bold=key.precision == _main_precision(shown, key))
    _name_curves(axes, study, shown)
    _draw_levels(axes, study)
    _title(figure, study, shown)
    return figure


def _shown(study: WorkPrecision) -> dict[Key, list[Run]]:
    limit = LOST * study.reference.extent
    kept = {key: [run for run in curve if run.error < limit] for key, curve in curves(study.runs).items()}
    return {key: curve for key, curve in kept.items() if curve}


def _main_precision(shown: Mapping[Key, list[Run]], key: Key) -> str:
    """The precision whose curve of an integrator is drawn boldly and named."""
    return "double" if Key(key.integrator, "double") in shown else "single"


def _set_up(axes: Axes, study: WorkPrecision, runs: Sequence[Run]) -> None:
    times = [run.seconds for run in runs]
    errors = [run.error for run in runs if run.error > 0]
    known = study.known
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(min(times) / 1.6, max(times) * 1.25)
    lowest = min([*errors, known] if known > 0 else errors)
    axes.set_ylim(lowest / 6.0, max(errors) * 3.0)
    axes.set_xlabel("wall time of the simulation, s")
    axes.set_ylabel("position error, m")
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(True, which="major", color="#eaeef2", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.yaxis.set_major_locator(LogLocator(numticks=12))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda time, _: f"{time:g}"))
    axes.xaxis.set_minor_formatter(FuncFormatter(_between if max(times) < MANY * min(times) else lambda *_: ""))
    axes.tick_params(which="minor", length=2, color=PALE)
    axes.tick_params(which="major", length=4)


def _between(time: float, _: int | None) -> str:
    """A time between powers of ten, where it has one of the digits that leave room for its like."""
    return f"{time:g}" if f"{time:e}"[0] in "25" else ""


def _mark_front(axes: Axes, study: WorkPrecision) -> None:
    front = [run for run in study.front if run.error > 0]
    axes.plot(
        [run.seconds for run in front],
        [run.error for run in front],
        color="#ffd33d",
        alpha=0.55,
        linewidth=9,
        solid_capstyle="round",
        solid_joinstyle="round",
        zorder=1,
    )


def _draw_curve(axes: Axes, key: Key, curve: Sequence[Run], *, bold: bool) -> None:
    colour, peer = colour_of(key.integrator), curve[0].peer
    axes.plot(
        [run.seconds for run in curve],
        [_drawn(axes, run) for run in curve],
        color=colour,
        linewidth=1.5 if bold else 0.9,
        linestyle=(0, (4, 1.5)) if peer else "-",
        alpha=1.0 if bold else 0.65,
        marker="s" if peer else "o",
        markersize=4.2 if bold else 3.6,
        markerfacecolor=colour if bold else "white",
        markeredgecolor="white" if bold else colour,
        markeredgewidth=0.6 if bold else 0.9,
        zorder=3 if bold else 2,
    )


def _draw_levels(axes: Axes, study: WorkPrecision) -> None:
    """What errors are held against: a pixel, roundoff, and how well the reference itself is known."""
    low, high = axes.get_ylim()
    levels = [(level, f"roundoff floor in {precision} precision") for precision, level in study.floors.items()]
    if study.metres_a_pixel is not None:
        levels.append((0.5 * study.metres_a_pixel, "½ pixel"))
    notes = Notes(axes, GREY)
    known = study.known
    if known > low:
        axes.axhspan(low, known, facecolor="#f6f8fa", edgecolor=PALE, hatch="////", linewidth=0, zorder=0.5)
        notes.put(f"the reference is known to {_metres(known)}", known, above=False)
    for level, name in sorted(level for level in levels if low < level[0] < high):
        axes.axhline(level, color=GREY, linewidth=0.8, linestyle=(0, (1, 2)), zorder=1.5)
        notes.put(f"{name}: {_metres(level)}", level)


def _drawn(axes: Axes, run: Run) -> float:
    """The height at which a run is drawn, m: near the lower edge where it cannot be told from the reference."""
    return max(run.error, 2.0 * float(axes.get_ylim()[0]))


def _name_curves(axes: Axes, study: WorkPrecision, shown: Mapping[Key, list[Run]]) -> None:
    """Names in the right margin, in the order of the ends of the curves, each joined to its end."""
    named = [key for key in shown if key.precision == _main_precision(shown, key)]
    ends = {key: shown[key][-1] for key in named}
    to_axes = axes.transData + axes.transAxes.inverted()
    heights = {key: float(to_axes.transform((run.seconds, _drawn(axes, run)))[1]) for key, run in ends.items()}
    for key, height in _spaced(heights, gap=0.052).items():
        run, colour = ends[key], colour_of(key.integrator)
        axes.annotate(
            _name(study, key),
            xy=(run.seconds, _drawn(axes, run)),
            xytext=((NAMES - LEFT) / (RIGHT - LEFT), height),
            textcoords="axes fraction",
            va="center",
            color=colour,
            fontsize=8.5,
            fontweight="bold",
            arrowprops={
                "arrowstyle": "-",
                "color": colour,
                "linewidth": 0.6,
                "alpha": 0.6,
                "shrinkA": 2,
                "shrinkB": 3,
                "relpos": (0.0, 0.5),
            },
            annotation_clip=False,
            zorder=2.5,
        )


def _spaced(heights: Mapping[Key, float], gap: float) -> dict[Key, float]:
    """Heights moved apart to at least a gap, in their order, and kept within 0 and 1 as far as they fit."""
    order = sorted(heights, key=lambda key: heights[key])
    placed: dict[Key, float] = {}
    below = -gap / 2
    for key in order:
        below = max(heights[key], below + gap)
        placed[key] = below
    above = max(1.0, gap * (len(order) - 1)) + gap
    for key in reversed(order):
        above = min(placed[key], above - gap)
        placed[key] = above
    return placed


def _name(study: WorkPrecision, key: Key) -> str:
    fitted = study.orders.get(key)
    return key.integrator.replace("_", " ") + (f", p = {fitted:.1f}" if fitted is not None else "")


def _title(figure: Figure, study: WorkPrecision, shown: Mapping[Key, list[Run]]) -> None:
    scene = study.scene
    figure.text(LEFT, 0.955, scene.title or scene.name, fontsize=13, fontweight="bold", va="center")
    count = sum(some for some, _ in study.particles.values())
    whose = "the largest at any frame" if count < 20 else "of 95 in 100 particles, at the worst frame"
    what = f"{count:,} particle{'s' * (count != 1)}, {scene.frame_count} frames; error {whose}"
    figure.text(LEFT, 0.912, what, fontsize=8.5, color=GREY, va="center")
    precisions = {key.precision for key in shown}
    handles = [Line2D([], [], color="#ffd33d", alpha=0.55, linewidth=7, label="Pareto front")]
    if len(precisions) == 2:
        for precision, filling in (("double precision", GREY), ("single", "white")):
            style: dict[str, Any] = {"marker": "o", "markersize": 4.5, "markeredgecolor": GREY}
            style["markerfacecolor"] = filling
            handles.append(Line2D([], [], color=GREY, linewidth=1.0, label=precision, **style))
    figure.legend(
        handles=handles,
        loc="center right",
        bbox_to_anchor=(0.985, 0.955),
        ncols=len(handles),
        frameon=False,
        fontsize=8,
        handlelength=1.6,
        columnspacing=1.4,
    )


def _metres(length: float) -> str:
    """A length in the unit that reads best, or in powers of ten of a metre."""
    for unit, size in (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9)):
        if length >= size:
            return f"{length / size:.{2 if length < 100 * size else 3}g} {unit}"
    mantissa, exponent = f"{length:.0e}".split("e")
    return f"{mantissa}·10$^{{{int(exponent)}}}$ m"

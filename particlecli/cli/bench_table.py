"""The result of `particlecli bench` as a table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from particlecli.accuracy.curves import WorkPrecision
from particlecli.accuracy.runs import Run

WIDEST = 128
"""Columns that the table takes where it is not shown on a terminal."""


def show_table(result: WorkPrecision, files: Sequence[Path]) -> None:
    """Prints what a study came to: what was measured, every run, and what follows."""
    console = Console(highlight=False, soft_wrap=True)
    for line in _head(result):
        console.print(line)
    wide = console if console.is_terminal else Console(highlight=False, width=WIDEST)
    wide.print(_runs(result))
    for line in _foot(result):
        console.print(line)
    for file in files:
        console.print(f"  wrote {file}", markup=False)


def _head(result: WorkPrecision) -> list[str]:
    scene, reference = result.scene, result.reference
    groups = [
        f"{name} {some:,}" + (f" of {total:,}" if some < total else "")
        for name, (some, total) in result.particles.items()
    ]
    return [
        scene.title or scene.name,
        f"  {_frames(result)}; particles: {', '.join(groups)}; {result.threads} threads",
        f"  errors against {reference.method}; known to {_metres(result.known)}",
        "  error: at the worst frame, of 95 in 100 particles of the group that is furthest off",
        "",
    ]


def _frames(result: WorkPrecision) -> str:
    frames = result.scene.frame_count
    return f"{frames} frames" if frames == result.frames_of else f"the first {frames} of {result.frames_of} frames"


def _runs(result: WorkPrecision) -> Table:
    conserving = any(run.energy_drift is not None for run in result.runs)
    seen = any(run.error_pixels is not None for run in result.runs)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("  integrator", no_wrap=True)
    headers = ["step", "error", *(["on screen"] if seen else []), "largest", "at the end"]
    headers += [*(["energy"] if conserving else []), "time", "evaluations", "steps/s"]
    for header in headers:
        table.add_column(header, justify="right", no_wrap=True)
    table.add_column("")
    last = None
    for run in result.runs:
        key = (run.integrator, run.precision)
        if last is not None and key != last:
            table.add_row()
        table.add_row(*_row(run, seen, conserving, run in result.front), style="bold" if run in result.front else "")
        last = key
    return table


def _row(run: Run, seen: bool, conserving: bool, best: bool) -> list[str]:
    name = f"{'★' if best else ' '} {run.integrator}, {run.precision}"
    pace = _pace(run)
    if run.deviation is None:
        return [name, pace, "failed", *[""] * (2 + seen + conserving), _seconds(run.seconds)]
    drift = "" if run.energy_drift is None else f"{run.energy_drift:.0e}"
    pixels = "" if run.error_pixels is None else f"{run.error_pixels:.2g} px"
    return [
        name,
        pace,
        _metres(run.error),
        *([pixels] if seen else []),
        _metres(run.deviation.worst.largest),
        _metres(run.deviation.final.p95),
        *([drift] if conserving else []),
        _seconds(run.seconds),
        _big(run.evaluations),
        _big(run.particle_steps / run.seconds),
        f"scaled ×{run.scaled:.3g}" if run.scaled > 1 else "",
    ]


def _foot(result: WorkPrecision) -> list[str]:
    lines = ["", "  ★ no other run is both quicker and more accurate"]
    lines += [
        f"  {run.integrator}, {run.precision}, at {_pace(run)} failed: {run.trouble}"
        for run in result.runs
        if run.deviation is None
    ]
    orders = [
        f"{integrator} {order:.2f}" + ("" if precision == "double" else " (single)")
        for (integrator, precision), order in result.orders.items()
    ]
    if orders:
        lines.append(f"  measured order: {', '.join(orders)}")
    lines += [
        f"  roundoff leaves {_metres(floor)} in {precision} precision" for precision, floor in result.floors.items()
    ]
    if result.no_peers:
        lines.append(f"  no peers: {result.no_peers}")
    if result.left_out or result.scene.frame_count < result.frames_of:
        lines.append(f"  this took {result.seconds:.0f} s, and --budget lets it take longer")
    if result.left_out:
        lines.append(f"  left out for want of time: {', '.join(result.left_out)}")
    return [*lines, ""]


def _pace(run: Run) -> str:
    """The step or the tolerance."""
    return f"{run.tolerance:.0e}" if run.step is None else f"{run.step:.3g} s"


def _metres(length: float) -> str:
    return f"{length:.1e} m"


def _seconds(seconds: float) -> str:
    return f"{seconds * 1e3:.1f} ms" if seconds < 0.1 else f"{seconds:.2f} s"


def _big(count: float) -> str:
    for limit, letter in ((1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k")):
        if count >= limit:
            return f"{count / limit:.3g} {letter}"
    return f"{count:.0f}"

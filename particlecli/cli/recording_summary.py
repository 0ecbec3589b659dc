"""What a recording holds, in facts and as text."""

from __future__ import annotations

import json
import shutil
import sys
from typing import TYPE_CHECKING, Any

import numpy as np

from particlecli.cli.columns import size, table
from particlecli.cli.sparkline import sparkline

if TYPE_CHECKING:
    from particlecli.sinks.recording.reader import Recording, Series

SHOWN = ("first", "least", "most", "last")
NARROWEST_PLOT, WIDEST_PLOT = 8, 60


def facts(recording: Recording) -> dict[str, Any]:
    """What a recording holds, as plain dictionaries, lists, strings and numbers."""
    groups = {name: _group(recording, name) for name in recording.groups}
    frames = max((group["frames"] for group in groups.values()), default=0)
    return {
        "file": str(recording.path),
        "title": recording.title,
        "particlecli": recording.version,
        "rerun": recording.container.version,
        "bytes": recording.container.size,
        "finished": recording.container.finished,
        "timelines": {name: _span(groups, name) for name in ("frame", "sim_time")},
        "frames": frames,
        "groups": groups,
        "entities": sorted(recording.entities),
        "series": {name: _series(series) for name, series in recording.series.items()},
        "scene": bool(recording.scene),
        "data_files": sorted(recording.attachments),
        "report": None if recording.report is None else json.loads(recording.report),
    }


def _span(groups: dict[str, Any], timeline: str) -> list[float] | None:
    spans = [group[timeline] for group in groups.values() if group[timeline]]
    return [min(first for first, _ in spans), max(last for _, last in spans)] if spans else None


def _group(recording: Recording, name: str) -> dict[str, Any]:
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    frames: list[int] = []
    times: list[float] = []
    counts: list[int] = []
    for frame, time, positions in recording.positions(name):
        frames.append(frame)
        times.append(time)
        counts.append(len(positions))
        for axis in range(3 if len(positions) else 0):  # along an axis NumPy's reductions are ten times slower
            low[axis] = min(low[axis], positions[:, axis].min())
            high[axis] = max(high[axis], positions[:, axis].max())
    moved = bool(np.isfinite(low).all())
    return {
        "frames": len(frames),
        "frame": [min(frames), max(frames)] if frames else None,
        "sim_time": [min(times), max(times)] if times else None,
        "points": sum(counts),
        "fewest": min(counts, default=0),
        "most": max(counts, default=0),
        "low": low.tolist() if moved else None,
        "high": high.tolist() if moved else None,
    }


def _series(series: Series) -> dict[str, float]:
    values = series.values
    return {
        "count": len(values),
        "first": float(values[0]),
        "last": float(values[-1]),
        "least": float(values.min()),
        "most": float(values.max()),
    }


def text(found: dict[str, Any], recording: Recording) -> str:
    """The facts as a person reads them, with small plots of the series."""
    state = "" if found["finished"] else ", unfinished: the run was stopped, or is still going on"
    lines = [
        f"{found['file']}  {found['title']}".rstrip(),
        f"  recorded   by particlecli {found['particlecli']}, Rerun {found['rerun']}; {size(found['bytes'])}{state}",
    ]
    if found["frames"]:
        frames, times = found["timelines"]["frame"], found["timelines"]["sim_time"]
        lines.append(
            f"  timelines  frame {frames[0]} … {frames[1]} ({found['frames']} recorded), "
            f"sim_time {times[0]:g} … {times[1]:g} s"
        )
    lines += _groups_text(found["groups"])
    others = [name for name in found["entities"] if not name.startswith(("/particles/", "/plots/", "/__properties"))]
    lines += ["", f"  other entities  {', '.join(sorted(others))}"]
    lines += _series_text(found["series"], recording)
    return "\n".join([*lines, *_documents_text(found, recording)])


def _groups_text(groups: dict[str, Any]) -> list[str]:
    if not groups:
        return []
    rows = [
        (name, f"{group['fewest']:,} … {group['most']:,}", f"{group['points']:,}", *_ranges(group))
        for name, group in groups.items()
    ]
    return ["", *table(("group", "points a frame", "in all", "x, m", "y, m", "z, m"), rows)]


def _ranges(group: dict[str, Any]) -> tuple[str, ...]:
    if group["low"] is None:
        return ("–",) * 3
    return tuple(f"{low:.4g} … {high:.4g}" for low, high in zip(group["low"], group["high"], strict=True))


def _series_text(series: dict[str, Any], recording: Recording) -> list[str]:
    if not series:
        return []
    names = sorted(series)
    rows = [(name, *(f"{series[name][which]:.6g}" for which in SHOWN)) for name in names]
    lines = table(("series", *SHOWN), rows)
    if sys.stdout.isatty():
        before = max(map(len, lines)) + 2
        width = min(WIDEST_PLOT, shutil.get_terminal_size().columns - before)
        if width >= NARROWEST_PLOT:
            plots = ["", *(sparkline(recording.series[name].values.tolist(), width) for name in names)]
            lines = [line.ljust(before) + plot for line, plot in zip(lines, plots, strict=True)]
    return ["", *lines]


def _documents_text(found: dict[str, Any], recording: Recording) -> list[str]:
    lines = [""]
    if found["scene"]:
        beside = f" and {', '.join(found['data_files'])}" if found["data_files"] else ""
        count = len(recording.scene.splitlines())
        lines.append(f"  scene   {count} lines{beside}; --extract-scene F.yaml gives it back")
    report = found["report"]
    if report is None:
        lines.append("  report  none: the run did not come to its end")
    else:
        wall = report["phases"]["wall_s"]
        lines.append(f"  report  {report['frames']} frames, {report['alive']:,} particles at the end, {wall:.2f} s")
    return lines

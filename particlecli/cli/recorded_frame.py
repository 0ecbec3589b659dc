"""The particles of one frame of a recording, printed or written as a table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from particlecli.cli.columns import table
from particlecli.errors import OutputError, UsageError

if TYPE_CHECKING:
    from particlecli.sinks.recording.reader import Points, Recording

PRINTED = 20
"""Particles of a group that are printed."""


def chosen(recording: Recording, frame: int | None, time: float | None) -> list[Points]:
    """The points of each group at a frame, or at the recorded frame nearest to a time.

    Raises:
        UsageError: the frame was not recorded, or the time is after the last one.
    """
    if not recording.groups:
        raise UsageError(f"{recording.path} has no particles")
    times = {index: at for index, at, _ in recording.positions(recording.groups[0])}
    if not times:
        raise UsageError(f"{recording.path} has no frames")
    last = max(times)
    if time is not None:
        if time > times[last] + 1e-9:
            raise UsageError(f"--time {time:g}: the recording ends at {times[last]:.6g} s")
        frame = min(times, key=lambda index: abs(times[index] - time))
    assert frame is not None
    if frame not in times:
        raise UsageError(f"--frame {frame}: not recorded; {_nearest(frame, list(times))}")
    return [_at(recording, group, frame) for group in recording.groups]


def _nearest(frame: int, frames: list[int]) -> str:
    if frame > frames[-1]:
        return f"the last frame is {frames[-1]}"
    return f"the nearest is {min(frames, key=lambda each: abs(each - frame))}"


def _at(recording: Recording, group: str, frame: int) -> Points:
    for points in recording.points(group):
        if points.frame == frame:
            return points
    raise UsageError(f"--frame {frame}: the recording ends before it for the group {group}")


def lines(frame: list[Points]) -> list[str]:
    """The first particles of each group, readably."""
    out = [f"frame {frame[0].frame}, {frame[0].time:.6g} s"]
    for points in frame:
        count = len(points.ids)
        out += ["", f"{points.group}: {count:,} particles"]
        if count == 0:
            continue
        shown = slice(0, PRINTED)
        colors = points.colors[shown] if len(points.colors) > 1 else [points.colors[0]] * min(count, PRINTED)
        rows = [
            (str(number), *(f"{value:.6g}" for value in position), f"#{color >> 8:06x}")
            for number, position, color in zip(
                points.ids[shown].tolist(), points.positions[shown].tolist(), map(int, colors), strict=True
            )
        ]
        out += table(("id", "x", "y", "z", "color"), rows)
        if count > PRINTED:
            out.append(f"  … and {count - PRINTED:,} more; --export F.csv or F.npz writes all")
    return out


def write(frame: list[Points], target: Path) -> None:
    """Writes all particles as a table: time, frame, group, id, position; the columns of a trajectory.

    Raises:
        OutputError: the file cannot be written.
    """
    import numpy as np

    from particlecli.sinks.tables import Block, CsvTable, NpzTable

    counts = [len(points.ids) for points in frame]
    block: Block = {
        "time": np.full(sum(counts), frame[0].time),
        "frame": np.full(sum(counts), frame[0].frame, np.int32),
        "group": np.repeat(np.arange(len(frame), dtype=np.int32), counts),
        "id": np.concatenate([points.ids for points in frame]).astype(np.int64),
        "position": np.concatenate([points.positions for points in frame]),
    }
    try:
        out = (CsvTable if target.suffix.lower() == ".csv" else NpzTable)(target)
        out.append([points.group for points in frame], block)
        out.finish()
    except OSError as error:
        raise OutputError(f"cannot write {target}: {error.strerror or error}") from None

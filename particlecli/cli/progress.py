"""Shows how far a run is, on stderr: a bar on a terminal, a plain line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from particlecli.cli.console import message

if TYPE_CHECKING:
    from particlecli.run import Progress

Show = Callable[["Progress"], None]

_SECONDS_BETWEEN_LINES = 5.0


@contextmanager
def progress(*, quiet: bool, what: str = "") -> Iterator[Show | None]:
    """What is to be called after each frame, of a run or of what else is named; none when nothing is to be shown."""
    if quiet:
        yield None
    elif sys.stderr.isatty():
        with _bar(what) as show:
            yield show
    else:
        yield _lines(time.monotonic, what)


@contextmanager
def _bar(what: str) -> Iterator[Show]:
    from rich import progress as rich
    from rich.console import Console

    columns = (
        rich.TextColumn("{task.description}"),
        rich.BarColumn(),
        rich.MofNCompleteColumn(),
        rich.TextColumn("frames · {task.fields[alive]:,} particles ·"),
        rich.TimeRemainingColumn(),
        rich.TextColumn("left"),
    )
    with rich.Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("compiling", total=None, alive=0)

        def show(state: Progress) -> None:
            bar.update(
                task,
                description=what or "running",
                completed=state.frames,
                total=state.frame_count,
                alive=state.alive,
            )

        yield show


def _lines(clock: Callable[[], float], what: str) -> Show:
    first: tuple[int, float] | None = None
    said = 0.0

    def show(state: Progress) -> None:
        nonlocal first, said
        now = clock()
        if first is None:  # the first frame also waits for compilation and tells nothing of the pace
            first, said = (state.frames, now), now
        elif now - said >= _SECONDS_BETWEEN_LINES:
            said = now
            pace = (now - first[1]) / (state.frames - first[0])
            left = pace * (state.frame_count - state.frames)
            done = f"{what} frame {state.frames} of {state.frame_count}".lstrip()
            message(f"{done}, {state.alive:,} particles, {left:.0f} s left")

    return show

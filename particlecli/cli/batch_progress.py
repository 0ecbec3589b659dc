"""Shows how far a batch is, on stderr: bars on a terminal, a line for each run elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from particlecli.batch.batch import Watcher
from particlecli.batch.worker import Failure
from particlecli.cli.console import message

if TYPE_CHECKING:
    from rich.progress import Progress as Bars
    from rich.progress import TaskID

    from particlecli.batch.jobs import Job
    from particlecli.batch.pool import Result
    from particlecli.run import Progress


@contextmanager
def watching(count: int, *, quiet: bool) -> Iterator[Watcher]:
    """What is to be told of a batch of so many jobs."""
    if quiet:
        yield Watcher()
    elif sys.stderr.isatty():
        with _bars() as bars:
            yield _BarWatcher(bars, count)
    else:
        yield _LineWatcher(count)


class _LineWatcher(Watcher):
    def __init__(self, count: int) -> None:
        self._count = count
        self._ended = 0

    def skipped(self, job: Job) -> None:
        self._say(job, "up to date")

    def done(self, job: Job, result: Result) -> None:
        self._say(job, "failed" if isinstance(result, Failure) else f"done, {result['phases']['wall_s']:.1f} s")

    def _say(self, job: Job, what: str) -> None:
        self._ended += 1
        message(f"{self._ended} of {self._count}: {job.name}: {what}")


class _BarWatcher(Watcher):
    def __init__(self, bars: Bars, count: int) -> None:
        self._bars = bars
        self._all = bars.add_task("all", total=count, unit="runs")
        self._tasks: dict[str, TaskID] = {}

    def skipped(self, job: Job) -> None:  # noqa: ARG002
        self._bars.advance(self._all)

    def started(self, job: Job) -> None:
        self._tasks[job.name] = self._bars.add_task(job.name, total=None, unit="frames")

    def progress(self, job: Job, progress: Progress) -> None:
        self._bars.update(self._tasks[job.name], completed=progress.frames, total=progress.frame_count)

    def done(self, job: Job, result: Result) -> None:
        self._bars.remove_task(self._tasks.pop(job.name))
        self._bars.advance(self._all)
        if isinstance(result, Failure):
            self._bars.console.print(f"failed: {job.name}: {result.message}", markup=False, highlight=False)


@contextmanager
def _bars() -> Iterator[Bars]:
    from rich import progress as rich
    from rich.console import Console

    columns = (
        rich.TextColumn("{task.description}", markup=False),
        rich.BarColumn(),
        rich.MofNCompleteColumn(),
        rich.TextColumn("{task.fields[unit]} ·"),
        rich.TimeRemainingColumn(),
        rich.TextColumn("left"),
    )
    with rich.Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        yield bars

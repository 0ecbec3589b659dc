"""batch(jobs): runs what is not up to date, keeps the manifest and makes the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from particlecli.batch.jobs import Job
from particlecli.batch.manifest import Manifest, replace
from particlecli.batch.page import page
from particlecli.batch.pool import Result, run_jobs
from particlecli.batch.worker import Failure
from particlecli.run import Progress

PAGE = "index.html"


class Watcher:
    """What is told while a batch runs; does nothing by itself."""

    def skipped(self, job: Job) -> None:
        """A job is up to date."""

    def started(self, job: Job) -> None:
        """A job begins."""

    def progress(self, job: Job, progress: Progress) -> None:
        """A job has come so far."""

    def done(self, job: Job, result: Result) -> None:
        """A job has ended."""


@dataclass(frozen=True)
class Outcome:
    """What became of a batch.

    Attributes:
        done, skipped: names of jobs that ran, and that were up to date.
        failed: why jobs failed, by name.
        manifest, page: the files.
    """

    done: tuple[str, ...]
    skipped: tuple[str, ...]
    failed: dict[str, Failure]
    manifest: Path
    page: Path


def batch(
    jobs: Sequence[Job],
    folder: Path,
    *,
    title: str,
    processes: int,
    force: bool = False,
    watcher: Watcher | None = None,
) -> Outcome:
    """Runs jobs, each in a process of its own, and makes `manifest.json` and `index.html` in the folder.

    Args:
        jobs: what to run.
        folder: of the batch.
        title: of the page.
        processes: how many run at once, at most.
        force: run also what is up to date.
        watcher: is told what happens.

    Raises:
        OutputError: the manifest or the page cannot be written.
    """
    watcher = watcher or Watcher()
    manifest = Manifest(folder, jobs)
    fresh = [job for job in jobs if not force and manifest.is_up_to_date(job)]
    due = [job for job in jobs if job not in fresh]
    for job in due:
        manifest.entries[job.name]["status"] = "waiting"
    manifest.write()
    for job in fresh:
        watcher.skipped(job)
    failed: dict[str, Failure] = {}

    def ended(job: Job, result: Result) -> None:
        manifest.finish(job, result)
        if isinstance(result, Failure):
            failed[job.name] = result
        watcher.done(job, result)

    target = folder / PAGE
    try:
        run_jobs(due, processes, started=watcher.started, progress=watcher.progress, done=ended)
    finally:
        replace(target, page(title, manifest.entries, folder))
    done = tuple(job.name for job in due if job.name not in failed)
    in_order = {job.name: failed[job.name] for job in due if job.name in failed}
    return Outcome(done, tuple(job.name for job in fresh), in_order, manifest.path, target)

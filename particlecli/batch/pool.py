"""Runs jobs side by side, each in a spawned process, as many as cores and memory allow."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

import psutil

from particlecli.batch.jobs import Job
from particlecli.batch.worker import Failure, Task, work
from particlecli.dynamics.plan import make_plan
from particlecli.errors import SceneError
from particlecli.run import Progress

PROCESS_BYTES = 600_000_000
"""What a process takes beside the state of the particles: libraries, kernels, pictures and an encoder."""

COPIES = 2
"""Frames are copies of the state; so much of it is there at once, at most."""

MEMORY_SHARE = 0.9
"""Of the memory that is free when a job is about to start."""

STOP_SECONDS = 10.0

Result = dict[str, Any] | Failure
"""The report of a job, or why there is none."""


@dataclass
class _Running:
    job: Job
    process: BaseProcess
    connection: Connection
    bytes: int


def run_jobs(
    jobs: Sequence[Job],
    processes: int,
    *,
    started: Callable[[Job], None],
    progress: Callable[[Job, Progress], None],
    done: Callable[[Job, Result], None],
) -> None:
    """Runs all jobs; one that fails does not stop the others.

    Args:
        jobs: what to run, in this order.
        processes: how many at once, at most; fewer while memory is short.
        started, progress, done: called in this process when a job begins, advances and ends.
    """
    waiting = [(job, need(job)) for job in jobs]
    running: list[_Running] = []
    threads = max(1, (os.cpu_count() or 1) // max(1, min(processes, len(jobs))))
    try:
        while waiting or running:
            while waiting and len(running) < processes and _fits(waiting[0][1], running):
                job, size = waiting.pop(0)
                started(job)
                running.append(_begin(job, size, threads))
            for connection in wait([each.connection for each in running]):
                here = next(each for each in running if each.connection is connection)
                found = _next(here)
                if isinstance(found, Progress):
                    progress(here.job, found)
                else:
                    running.remove(here)
                    here.process.join()
                    done(here.job, found)
    finally:
        for each in running:
            each.process.terminate()
        for each in running:
            each.process.join(STOP_SECONDS)
            each.process.kill()


def need(job: Job) -> int:
    """Bytes that a job will take, roughly; of one that cannot be planned, what a process takes anyway."""
    try:
        return PROCESS_BYTES + COPIES * make_plan(job.scene).memory
    except SceneError:
        return PROCESS_BYTES  # its process tells what is wrong


def _fits(size: int, running: Sequence[_Running]) -> bool:
    """Whether there is memory for one more, when those that run have taken all they need; one always runs."""
    if not running:
        return True
    promised = sum(max(0, each.bytes - _resident(each.process)) for each in running)
    return size + promised <= MEMORY_SHARE * psutil.virtual_memory().available


def _resident(process: BaseProcess) -> int:
    try:
        return int(psutil.Process(process.pid).memory_info().rss)
    except psutil.Error:
        return 0


def _begin(job: Job, size: int, threads: int) -> _Running:
    context = multiprocessing.get_context("spawn")  # Taichi does not survive a fork
    ours, theirs = context.Pipe(duplex=False)
    task = Task(job.path, job.overrides, job.folder, job.path.stem, job.quality, threads)
    process = context.Process(target=work, args=(task, theirs), name=job.name, daemon=True)
    process.start()
    theirs.close()
    return _Running(job, process, ours, size)


def _next(running: _Running) -> Progress | Result:
    try:
        found: Progress | Result = running.connection.recv()
    except EOFError:
        running.process.join()
        code = running.process.exitcode or 0
        how = f"was killed by signal {-code}, perhaps for want of memory" if code < 0 else f"ended with code {code}"
        return Failure(f"its process {how}", 3)
    return found

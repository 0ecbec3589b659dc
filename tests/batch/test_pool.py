"""Processes side by side, with work that is quickly done."""

from __future__ import annotations

import os
import signal
import time
from multiprocessing.connection import Connection
from types import SimpleNamespace
from typing import Any

import pytest

from particlecli.batch import pool
from particlecli.batch.batch import Watcher
from particlecli.batch.jobs import Job
from particlecli.batch.pool import run_jobs
from particlecli.batch.worker import Failure, Task
from particlecli.run import Progress
from tests.batch.conftest import MakeJobs


def pretend(task: Task, connection: Connection) -> None:
    """Work that dies for a seed of 1, fails for 2, and else takes a moment."""
    seed = task.overrides[0].removeprefix("seed=")
    connection.send(Progress(1, 2, 3))
    if seed == "1":
        os.kill(os.getpid(), signal.SIGKILL)
    if seed == "2":
        connection.send(Failure("did not want to", 3))
        return
    began = time.time()
    time.sleep(0.3)
    connection.send({"seed": seed, "began": began, "ended": time.time(), "threads": task.threads})


class Notes(Watcher):
    def __init__(self) -> None:
        self.told: list[str] = []
        self.results: dict[str, Any] = {}

    def started(self, job: Job) -> None:
        self.told.append(f"{job.name} started")

    def progress(self, job: Job, progress: Progress) -> None:
        self.told.append(f"{job.name} {progress.frames}/{progress.frame_count}")

    def done(self, job: Job, result: Any) -> None:
        self.told.append(f"{job.name} done")
        self.results[job.name] = result


@pytest.fixture(autouse=True)
def no_real_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "work", pretend)


def run(jobs: list[Job], processes: int) -> Notes:
    notes = Notes()
    run_jobs(jobs, processes, started=notes.started, progress=notes.progress, done=notes.done)
    return notes


def together(results: dict[str, Any], first: str, second: str) -> bool:
    return results[first]["began"] < results[second]["ended"] and results[second]["began"] < results[first]["ended"]


def test_a_job_that_fails_or_dies_does_not_stop_the_others(jobs: MakeJobs) -> None:
    notes = run(jobs("seed=1,2,3"), 2)
    assert notes.results["balls,seed=1"] == Failure("its process was killed by signal 9, perhaps for want of memory", 3)
    assert notes.results["balls,seed=2"] == Failure("did not want to", 3)
    assert notes.results["balls,seed=3"]["seed"] == "3"
    third = [line for line in notes.told if line.startswith("balls,seed=3")]
    assert third == ["balls,seed=3 started", "balls,seed=3 1/2", "balls,seed=3 done"]


def test_one_at_a_time_in_order(jobs: MakeJobs) -> None:
    results = run(jobs("seed=3,4"), 1).results
    assert list(results) == ["balls,seed=3", "balls,seed=4"]
    assert not together(results, *results)


def test_jobs_that_do_not_fit_into_memory_together_wait_for_each_other(
    jobs: MakeJobs, monkeypatch: pytest.MonkeyPatch
) -> None:
    small = SimpleNamespace(available=pool.PROCESS_BYTES // 2)
    monkeypatch.setattr(pool.psutil, "virtual_memory", lambda: small)
    results = run(jobs("seed=3,4"), 2).results
    assert not together(results, *results)


def test_need_grows_with_the_particles(jobs: MakeJobs) -> None:
    small, large = jobs(
        "particles.balls={layout: {type: ball, radius: 1, count: 10}},{layout: {type: ball, radius: 1, count: 1000000}}"
    )
    assert pool.need(large) - pool.need(small) > 2 * 900_000 * 24
    assert pool.need(small) >= pool.PROCESS_BYTES


def test_what_runs_is_stopped_when_the_watcher_is_interrupted(jobs: MakeJobs) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = {child.pid for child in pool.psutil.Process().children()}
    with pytest.raises(KeyboardInterrupt):
        run_jobs(jobs("seed=3"), 1, started=Watcher().started, progress=interrupt, done=Watcher().done)
    after = {child.pid for child in pool.psutil.Process().children() if child.status() != "zombie"}
    resource_trackers = 1
    assert len(after - before) <= resource_trackers

"""One job in a process of its own, which tells how far it is."""

from __future__ import annotations

import signal
import time
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from particlecli.errors import ParticleError
from particlecli.interruption import Interrupted, stop_on
from particlecli.run import Progress, Quality, RunOptions, run
from particlecli.scene.load import load_scene

SECONDS_BETWEEN = 0.2


@dataclass(frozen=True)
class Task:
    """What a process is to do; the fields as of `Job`, and worker threads."""

    path: Path
    overrides: tuple[str, ...]
    folder: Path
    name: str
    quality: Quality
    threads: int


@dataclass(frozen=True)
class Failure:
    """Why a job failed: in words, and the exit code that a run of it alone would have."""

    message: str
    code: int


def work(task: Task, connection: Connection) -> None:
    """Runs a task; sends `Progress` now and then, and at the end the report as a dictionary, or a `Failure`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the parent too, which tells its children
    stop_on(signal.SIGTERM)
    with suppress(Interrupted, BrokenPipeError):  # nobody listens any more
        connection.send(_outcome(task, connection))


def _outcome(task: Task, connection: Connection) -> dict[str, Any] | Failure:
    said = 0.0

    def tell(progress: Progress) -> None:
        nonlocal said
        if time.monotonic() - said >= SECONDS_BETWEEN:
            said = time.monotonic()
            connection.send(progress)

    try:
        scene = load_scene(task.path, task.overrides)
        options = RunOptions(name=task.name, folder=task.folder, quality=task.quality, threads=task.threads)
        return run(scene, options, tell).to_dict()
    except ParticleError as error:
        return Failure(str(error), error.exit_code)
    except MemoryError:
        return Failure("not enough memory", 3)
    except BrokenPipeError:
        raise
    except Exception as error:
        return Failure(f"particlecli has a bug: {type(error).__name__}: {error}", 70)

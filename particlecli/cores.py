"""The cores of the machine, and the threads of this process upon them."""

import contextlib
import functools
import os
from collections.abc import Iterable
from pathlib import Path

TASKS = Path("/proc/self/task")


@functools.cache
def usable() -> int:
    """How many cores this process may use: those that it may run on, or, if that is less, what its control group gets.

    Source: the Linux kernel's documentation of control groups, version 2, `cpu.max`.
    """
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    with contextlib.suppress(OSError, ValueError):
        quota, period = Path("/sys/fs/cgroup/cpu.max").read_text().split()
        count = min(count, max(1, round(int(quota) / int(period))))
    return count


def known() -> bool:
    """Whether the system tells of threads and cores what the functions below need: Linux does."""
    return hasattr(os, "sched_setaffinity") and TASKS.is_dir()


def threads() -> set[int]:
    """The numbers that the system gives the threads of this process; none if it does not tell."""
    return {int(each.name) for each in TASKS.iterdir()} if known() else set()


def spread(numbers: Iterable[int]) -> None:
    """Keep each of these threads, those that are still there, on one core, in turn."""
    allowed = sorted(os.sched_getaffinity(0))
    for place, number in enumerate(sorted(threads() & set(numbers))):
        with contextlib.suppress(ProcessLookupError):
            os.sched_setaffinity(number, {allowed[place % len(allowed)]})


def interruptions() -> int:
    """How often a thread of this process had to leave its core to another process, or to a thread that was woken."""
    import resource  # there is none on Windows

    return resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw

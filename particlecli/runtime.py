"""The Taichi runtime: the only place that starts it. One a process; a second start may reset it.

Taichi numbers fields from its start on and compiles the numbers into kernels. A system that is built in a fresh runtime
finds the kernels of an earlier one like it in the cache; built after that one, it would compile all of them again. So a
runtime that nothing uses any more is started afresh.
"""

import atexit
import contextlib
import gc
import io
import os
import weakref
from typing import Literal

from particlecli import cores, taichi_shortcuts

Precision = Literal["single", "double"]

COMPILED_FOR = 8
"""Kernels are compiled for so many threads, whatever fewer there are, so that all of them share the cache."""

_loaded = False
_started: tuple[Precision, int] | None = None
_epoch = 0
_users: weakref.WeakSet[object] = weakref.WeakSet()
_worn = False
_seen: set[str] = set()
_workers: set[int] = set()


def start(precision: Precision, threads: int | None = None, structure: str | None = None) -> None:
    """Start Taichi on the CPU, silently; does nothing when it already runs with these settings and is in use.

    A restart invalidates every field and kernel made before; with other settings also those in use.

    Args:
        precision: type of floating-point literals in kernels: f32 for "single", f64 for "double".
        threads: worker threads; none for one a core.
        structure: tells what will be built from what needs other kernels. A runtime that is not in use goes on as well
            if nothing like it was built before.
    """
    global _epoch, _started, _worn, _workers
    settings = (precision, threads or cores.usable())
    known = structure is None or structure in _seen
    if structure is not None:
        _seen.add(structure)
    if settings == _started and not (known and _abandoned()):
        return
    load()
    with contextlib.redirect_stdout(io.StringIO()):
        import taichi as ti

        before = cores.threads()
        ti.init(
            arch=ti.cpu,
            cpu_max_num_threads=settings[1],
            default_fp=ti.f64 if precision == "double" else ti.f32,
            fast_math=False,
            # Their passes took two thirds of the time of a compilation; LLVM does the same work later.
            cfg_optimization=False,
            advanced_optimization=False,
            offline_cache=True,
            # Else a thread takes 512 turns of a loop at least, whatever the loop asks for.
            make_cpu_multithreading_loop=False,
            cpu_block_dim_adaptive=False,
            default_cpu_block_dim=64,
        )
        # The pool of threads exists by now and takes no more of them than it has.
        ti.lang.impl.get_runtime().prog.config().cpu_max_num_threads = max(settings[1], COMPILED_FOR)
    _workers = cores.threads() - before
    if _epoch == 0:
        atexit.register(stop)  # Taichi writes its cache of kernels when it ends, and an exit may not end it
    _started = settings
    _epoch += 1
    _users.clear()
    _worn = False


def threads() -> int:
    """How many worker threads Taichi was started with."""
    assert _started is not None
    return _started[1]


def workers() -> set[int]:
    """The threads that were started with Taichi, as `cores.threads`."""
    return _workers


def use(user: object, *, wears: bool = False) -> None:
    """Let the runtime go on with the same settings as long as an object lives, which has fields.

    Args:
        user: the object.
        wears: whether its kernels are compiled for its fields alone, so that a fresh runtime is worth its start.
    """
    global _worn
    _users.add(user)
    _worn = _worn or wears


def _abandoned() -> bool:
    """Whether systems were built, and nothing that has fields lives any more."""
    if _worn and _users:
        gc.collect()
    return _worn and not _users


def load() -> None:
    """Import Taichi, silently. `start` does it too."""
    global _loaded
    if _loaded:
        return
    _loaded = True
    os.environ["ENABLE_TAICHI_HEADER_PRINT"] = "0"
    os.environ["TI_LOG_LEVEL"] = "error"
    with contextlib.redirect_stdout(io.StringIO()):
        taichi_shortcuts.take()


def epoch() -> int:
    """Changes whenever Taichi is started anew; what was made in another epoch is gone."""
    return _epoch


def stop() -> None:
    """Free all fields and kernels and end the Taichi runtime."""
    global _started
    if _started is not None:
        import taichi as ti

        ti.reset()
        _started = None

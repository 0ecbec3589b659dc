"""The Taichi runtime: the only place that starts it. One a process; a second start with other settings resets it."""

import atexit
import contextlib
import io
import os
import warnings
from typing import Any, Literal

Precision = Literal["single", "double"]

COMPILED_FOR = 8
"""Kernels are compiled for so many threads, whatever fewer there are, so that all of them share the cache."""

_started: tuple[Precision, int] | None = None
_epoch = 0


def start(precision: Precision, threads: int | None = None) -> None:
    """Start Taichi on the CPU, silently; does nothing when it already runs with these settings.

    A restart with other settings invalidates every field and kernel made before.

    Args:
        precision: type of floating-point literals in kernels: f32 for "single", f64 for "double".
        threads: worker threads; none for one a core.
    """
    global _epoch, _started
    settings = (precision, threads or os.cpu_count() or 1)
    if settings == _started:
        return
    os.environ["ENABLE_TAICHI_HEADER_PRINT"] = "0"
    os.environ["TI_LOG_LEVEL"] = "error"
    with contextlib.redirect_stdout(io.StringIO()):
        import taichi as ti

        ti.init(
            arch=ti.cpu,
            cpu_max_num_threads=settings[1],
            default_fp=ti.f64 if precision == "double" else ti.f32,
            fast_math=False,
            cfg_optimization=False,  # its passes took half the time of a compilation; LLVM does the same work later
            offline_cache=True,
        )
        # The pool of threads exists by now and takes no more of them than it has.
        ti.lang.impl.get_runtime().prog.config().cpu_max_num_threads = max(settings[1], COMPILED_FOR)
    if _epoch == 0:
        atexit.register(stop)  # Taichi writes its cache of kernels when it ends, and an exit may not end it
    _trace_fast()
    warnings.filterwarnings("ignore", message=".*Calling non-taichi function.*")
    warnings.filterwarnings("ignore", message=".*List is a built-in.*")
    _started = settings
    _epoch += 1


def _trace_fast() -> None:
    """Let Taichi name file and line alone where it traces kernels.

    It lays out the source of every node in lines of 80 characters, in case there is an error to show, which takes a
    third of the time of tracing; and kernels are traced in every process, also those that the cache has compiled.
    """
    from taichi.lang.ast.ast_transformer_utils import ASTTransformerContext

    def position(context: Any, node: Any) -> str:
        return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}:\n'

    ASTTransformerContext.get_pos_info = position


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

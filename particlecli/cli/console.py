"""Turns errors into messages and exit codes. stdout carries results, stderr everything else."""

from __future__ import annotations

import os
import signal
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import particlecli
from particlecli.errors import ParticleError
from particlecli.interruption import Interrupted

_PACKAGE = str(Path(particlecli.__file__).parent)
_OUT_OF_MEMORY = 3
_BUG = 70  # EX_SOFTWARE of sysexits.h: not one of the codes that say something about the scene
_PIPE_CLOSED = 141  # 128 + SIGPIPE, which Windows does not have


def message(text: str) -> None:
    """Prints a message to stderr."""
    print(text, file=sys.stderr)


@contextmanager
def errors_become_messages() -> Iterator[None]:
    """Ends the process with one message and the exit code of what went wrong, if anything does."""
    try:
        yield
        sys.stdout.flush()
    except ParticleError as error:
        message(str(error))
        sys.exit(error.exit_code)
    except MemoryError:
        message("not enough memory; fewer particles or a smaller picture need less")
        sys.exit(_OUT_OF_MEMORY)
    except Interrupted as stop:
        message("terminated" if stop.signal == signal.SIGTERM else "interrupted")
        sys.exit(128 + stop.signal)
    except BrokenPipeError:
        # Python flushes stdout once more when it exits, which must not complain either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(_PIPE_CLOSED)


@contextmanager
def bugs_become_messages() -> Iterator[None]:
    """Names the place of an unexpected exception; PARTICLECLI_DEBUG=1 shows the traceback."""
    try:
        yield
    except Exception as error:
        if os.environ.get("PARTICLECLI_DEBUG"):
            traceback.print_exc()
        places = traceback.extract_tb(error.__traceback__)
        place = next((each for each in reversed(places) if each.filename.startswith(_PACKAGE)), places[-1])
        message(
            f"particlecli has a bug: {type(error).__name__}: {error} ({place.filename}:{place.lineno})\n"
            "Please report it with the scene; PARTICLECLI_DEBUG=1 shows the whole traceback."
        )
        sys.exit(_BUG)

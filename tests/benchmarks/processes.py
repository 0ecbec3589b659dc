"""Wall time of whole commands."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence


def seconds(command: Sequence[str], environment: Mapping[str, str] | None = None) -> float:
    """Wall time of `python` with these arguments, s.

    Raises:
        subprocess.CalledProcessError: the command failed; carries what it wrote to stderr.
    """
    began = time.perf_counter()
    subprocess.run(
        [sys.executable, *command],
        env={**os.environ, **(environment or {})},
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    return time.perf_counter() - began


def fastest(commands: Mapping[str, Sequence[str]], goes: int) -> dict[str, float]:
    """The fastest of several goes at each command, s, the commands in turn."""
    times = [{name: seconds(command) for name, command in commands.items()} for _ in range(goes)]
    return {name: min(each[name] for each in times) for name in commands}

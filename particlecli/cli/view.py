"""`particlecli view`: a recording in the Rerun viewer."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Annotated

import typer

from particlecli.cli.console import message
from particlecli.cli.options import RecordingFile
from particlecli.errors import UsageError


def command(
    file: RecordingFile,
    web: Annotated[bool, typer.Option("--web", help="In a browser, served from this machine.")] = False,
) -> None:
    """Open a recording in the Rerun viewer; returns when the viewer is closed."""
    from particlecli.sinks.recording.container import examine

    cut = "" if examine(file).finished else f"{file} is cut short"
    if not web and _screenless():
        also = f"{cut}, and " if cut else ""
        raise UsageError(f"{also}there is no screen to show the viewer on; --web shows it in a browser")
    if cut:
        message(f"{cut}; the viewer shows what is there")
    command = [sys.executable, "-m", "rerun", *(["--web-viewer"] if web else []), str(file)]
    code = subprocess.run(command, check=False).returncode
    if code:
        raise UsageError(f"the Rerun viewer ended with code {code}")


def _screenless() -> bool:
    return sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))

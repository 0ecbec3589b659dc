"""The command line as a user meets it, in a process of its own where that matters."""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import particlecli
from particlecli.cli.app import run_app

Result = subprocess.CompletedProcess[str]
Cli = Callable[..., Result]

SCENE = """\
title: Three balls
duration: 0.2
fps: 10
particles:
  balls: {positions: [[0, 1, 0], [0, 2, 0], [0, 3, 0]]}
forces:
  - {type: gravity}
integrator: {type: symplectic_euler, dt: 0.05}
camera: {resolution: [64, 48]}
"""


@pytest.fixture(autouse=True)
def package_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets processes that start in other folders find the package, installed or not."""
    monkeypatch.setenv("PYTHONPATH", str(Path(particlecli.__file__).parents[1]))


@pytest.fixture
def process(tmp_path: Path) -> Cli:
    """Runs `particlecli` with arguments in a process of its own, in a folder of the test's own."""

    def call(*arguments: str | Path) -> Result:
        command = [sys.executable, "-m", "particlecli", *map(str, arguments)]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)

    return call


@pytest.fixture
def cli(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Cli:
    """Like `process`, but within this one, which has loaded by now what all commands share."""

    def call(*arguments: str | Path) -> Result:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["particlecli", *map(str, arguments)])
        out, err, code = io.StringIO(), io.StringIO(), 0
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                run_app()
            except SystemExit as end:
                code = end.code if isinstance(end.code, int) else int(end.code is not None)
        return Result(sys.argv, code, out.getvalue(), err.getvalue())

    return call


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """A small scene file without outputs, named balls.yaml."""
    path = tmp_path / "balls.yaml"
    path.write_text(SCENE)
    return path


def imported_by(code: str) -> set[str]:
    """The modules that are loaded after a process has run some code, which must not fail."""
    command = [sys.executable, "-c", f"from pathlib import Path\n{code}\nimport sys; print(*sys.modules)"]
    return set(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())

"""How long the command line makes one wait: help, and the check of a scene."""

from __future__ import annotations

import tempfile
from pathlib import Path

from tests.benchmarks.figures import Figure
from tests.benchmarks.processes import fastest, seconds

SLOWEST = 150.0
"""ms."""

GOES = 10


def measure() -> list[Figure]:
    """Milliseconds of whole commands, beside what Python and typer alone take."""
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "sparks.yaml"
        seconds(["-m", "particlecli", "new", str(scene)])
        commands = {
            "help": ["-m", "particlecli", "--help"],
            "validate": ["-m", "particlecli", "validate", str(scene)],
            "python -c pass": ["-c", "pass"],
            "python -c 'import typer'": ["-c", "import typer"],
        }
        times = {name: 1e3 * value for name, value in fastest(commands, GOES).items()}
    peers = {name: times[name] for name in times if name.startswith("python")}
    return [
        Figure("particlecli --help", times["help"], "ms", "less", must=SLOWEST, peers=peers),
        Figure("particlecli validate", times["validate"], "ms", "less", peers=peers),
    ]

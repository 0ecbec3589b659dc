"""The campfire as a newcomer runs it: the whole command, with Taichi's cache warm and empty."""

from __future__ import annotations

import tempfile
from pathlib import Path

from tests.benchmarks.figures import Figure
from tests.benchmarks.processes import seconds

SCENE = Path(__file__).parents[2] / "scenes" / "campfire.yaml"
WARM, COLD = 12.0, 25.0
"""s."""


def measure() -> list[Figure]:
    """Seconds from one line typed to the video there."""
    if not SCENE.exists():
        return [Figure("campfire, whole command", None, "s", "less", must=WARM, note=f"no {SCENE.name}")]
    with tempfile.TemporaryDirectory() as cache, tempfile.TemporaryDirectory() as folder:
        # A cache of its own: what the first run leaves there is what the second one finds.
        command = ["-m", "particlecli", "run", str(SCENE), "-o", folder, "--quiet"]
        environment = {"TI_OFFLINE_CACHE_FILE_PATH": cache}
        cold = seconds(command, environment)
        warm = seconds(command, environment)
    return [
        Figure("campfire, warm cache", warm, "s", "less", must=WARM, note="8 s at 30 fps, 1280×720"),
        Figure("campfire, cold first run", cold, "s", "less", must=COLD),
    ]

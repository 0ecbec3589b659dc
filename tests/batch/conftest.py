"""Jobs without work, and reports without runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from particlecli.batch.jobs import Job, make_jobs
from particlecli.batch.sweep import parse_sweep

SCENE = """\
title: Balls
duration: 0.1
fps: 10
particles:
  balls: {positions: [[0, 1, 0]]}
forces: [{type: gravity}, {type: drag, coefficient: 1}]
integrator: {type: euler, dt: 0.05}
outputs: [{type: trajectory, path: balls.npz}]
"""

MakeJobs = Callable[..., list[Job]]


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "balls.yaml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def jobs(scene: Path, tmp_path: Path) -> MakeJobs:
    """Jobs of the scene with sweeps."""
    return lambda *sets: make_jobs([scene], [parse_sweep(each) for each in sets], tmp_path / "out", "final")


def report(*files: str, **facts: Any) -> dict[str, Any]:
    """What the page and the manifest read of a report."""
    return {
        "files": list(files),
        "duration": 1.0,
        "frames": 11,
        "births": {"balls": 3},
        "deaths": {"balls": {"expired": 1}},
        "alive": 2,
        "particle_steps_per_second": 2e6,
        "phases": {"wall_s": 1.5, "simulate_s": 0.5},
        "estimated_error": {"balls": {"metres": {"p95": 0.01}, "pixels": {"p95": 0.3}, "trend": "converging"}},
        **facts,
    }

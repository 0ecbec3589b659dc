"""What the estimate of its error takes of a run, with the outputs that scenes have and without any."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from tests.benchmarks.figures import Figure

SCENES = Path(__file__).parents[2] / "scenes"
TOGETHER = ("snake", "fish_school", "galaxies", "reference/catenary", "reference/pleiades")
ALONE = ("campfire", "fire_whirl", "fountain", "reference/incline")
"""Scenes whose particles act on each other, and such as have samples."""

MOST = 5.0
"""Per cent."""


def measure() -> list[Figure]:
    """Shares of the wall time of runs whose kernels have been compiled before."""
    return [
        figure
        for name in (*TOGETHER, *ALONE)
        for options, made in (([], "with its outputs"), (["--no-output"], "without output"))
        for figure in [_figure(name, made, _report(name, options))]
    ]


def _figure(name: str, made: str, report: dict[str, Any]) -> Figure:
    phases = report["phases"]
    trends = sorted({error["trend"] for error in report["estimated_error"].values()})
    missing = [f"not: {', '.join(report['not_estimated'])}"] if report["not_estimated"] else []
    kept = [f"drift of {', '.join(report['conserved'])}"] if report["conserved"] else []
    return Figure(
        what=f"{name}, {made}",
        value=100.0 * phases["estimate_s"] / phases["wall_s"],
        unit="%",
        better="less",
        must=MOST,
        note="; ".join([f"of {phases['wall_s']:.1f} s", *trends, *missing, *kept]),
    )


def _report(name: str, options: list[str]) -> dict[str, Any]:
    """The report of a run; without output of the second one, when its kernels are there."""
    report: dict[str, Any] = {}
    for _ in range(2 if options else 1):
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, "-m", "particlecli", "run", str(SCENES / f"{name}.yaml"), "-o", folder]
            done = subprocess.run([*command, "--json", "--quiet", *options], capture_output=True, check=True)
        report = json.loads(done.stdout)
    return report

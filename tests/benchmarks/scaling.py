"""Cost against the number of particles, from ten thousand to thirty million."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.benchmarks.contest import Ours, timed
from tests.benchmarks.cost_plot import save_cost_plot
from tests.benchmarks.dust import STEPS, Dust
from tests.benchmarks.figures import Figure

COUNTS = (10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000, 30_000_000)
FRAMES = 6
PICTURE = Path(__file__).parents[2] / "outputs" / "scaling.png"


def measure() -> list[Figure]:
    """The exponent p of cost ~ countᵖ, fitted to the seconds a frame; draws the curve."""
    seconds = np.array([_seconds_a_frame(count) for count in COUNTS])
    counts = np.array(COUNTS, float)
    exponent, _ = np.polyfit(np.log(counts), np.log(seconds), 1)
    picoseconds = seconds / counts / STEPS * 1e12
    title = f"Cost grows as the number of particles to the power {exponent:.2f}"
    unit = "time a particle-step, ps"
    save_cost_plot(PICTURE, counts, picoseconds, counted="particles", measured=unit, title=title, color="#d9480f")
    spread = f"{picoseconds.min():.0f} to {picoseconds.max():.0f} ps a particle-step"
    return [
        Figure("exponent of cost in the number", float(exponent), "", "less", must=1.05, note=spread),
    ]


def _seconds_a_frame(count: int) -> float:
    """Mean over the frames of the faster of two goes."""
    ours = Ours(Dust(count=count, frames=FRAMES))
    times = []
    for _ in range(2):
        ours.restart()
        times.append([timed(ours.advance) for _ in range(FRAMES)])
    return float(np.min(times, axis=0).mean())

"""Cost against the number of particles, from ten thousand to thirty million."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.benchmarks.contest import Ours, timed
from tests.benchmarks.dust import STEPS, Dust
from tests.benchmarks.figures import Figure

COUNTS = (10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000, 30_000_000)
FRAMES = 6
Curve = NDArray[np.float64]
PICTURE = Path(__file__).parents[2] / "outputs" / "scaling.png"


def measure() -> list[Figure]:
    """The exponent p of cost ~ countᵖ, fitted to the seconds a frame; draws the curve."""
    seconds = np.array([_seconds_a_frame(count) for count in COUNTS])
    counts = np.array(COUNTS, float)
    exponent, _ = np.polyfit(np.log(counts), np.log(seconds), 1)
    picoseconds = seconds / counts / STEPS * 1e12
    _draw(counts, picoseconds, float(exponent))
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


def _draw(counts: Curve, picoseconds: Curve, exponent: float) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7.2, 4.2), layout="constrained")
    axes.plot(counts, picoseconds, "o-", color="#d9480f", linewidth=1.8, markersize=6)
    axes.set_xscale("log")
    axes.set_ylim(0, 1.25 * picoseconds.max())
    axes.set_xlabel("particles")
    axes.set_ylabel("time a particle-step, ps")
    axes.set_title(f"Cost grows as the number of particles to the power {exponent:.2f}", loc="left")
    axes.grid(axis="y", color="#dddddd", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    PICTURE.parent.mkdir(exist_ok=True)
    figure.savefig(PICTURE, dpi=150)
    pyplot.close(figure)

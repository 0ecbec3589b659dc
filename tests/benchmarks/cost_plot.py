"""Cost against the number of particles, as a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray


def save_cost_plot(
    path: Path,
    counts: NDArray[np.float64],
    cost: NDArray[np.float64],
    *,
    counted: str,
    measured: str,
    title: str,
    color: str,
) -> None:
    """Draws cost over counts, both of shape (n,), and writes it to a file.

    Args:
        counted, measured: what the axes are of, with units.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7.2, 4.2), layout="constrained")
    axes.plot(counts, cost, "o-", color=color, linewidth=1.8, markersize=6)
    axes.set_xscale("log")
    axes.set_ylim(0, 1.25 * cost.max())
    axes.set_xlabel(counted)
    axes.set_ylabel(measured)
    axes.set_title(title, loc="left")
    axes.grid(axis="y", color="#dddddd", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, dpi=150)
    pyplot.close(figure)

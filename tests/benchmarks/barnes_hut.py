"""Attraction by the octree: its cost from ten thousand to three million bodies, its error, and the direct sum."""

from __future__ import annotations

import resource
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.coupled.tree_attraction import TreeAttraction
from particlecli.scene import forces as scene
from tests.benchmarks.attraction import SOFTENING, direct_rate
from tests.benchmarks.contest import timed
from tests.benchmarks.cost_plot import save_cost_plot
from tests.benchmarks.figures import Figure
from tests.dynamics.coupled.cloud import Cloud

COUNTS = (10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000)
MILLION = 1_000_000
ANGLE = 0.5
TARGETS = 200
"""Bodies whose forces are compared with those by the direct sum."""

PICTURE = Path(__file__).parents[2] / "outputs" / "barnes_hut.png"
Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class Measured:
    """An evaluation of all forces: s, and the root mean square of the relative errors of sampled ones."""

    seconds: float
    error: float


def measure() -> list[Figure]:
    """Single precision, opening angle 0.5, bodies in Plummer's sphere."""
    measured = {count: _measured(count) for count in COUNTS}
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    counts = np.array(COUNTS, float)
    ideal = counts * np.log2(counts)
    cost = np.array([each.seconds for each in measured.values()]) / ideal
    title, unit = "Barnes–Hut: cost grows as N log N", "time of all forces by N log₂ N, ns"
    save_cost_plot(PICTURE, counts, cost * 1e9, counted="bodies N", measured=unit, title=title, color="#1864ab")
    exponent, _ = np.polyfit(np.log(ideal), np.log(cost * ideal), 1)
    million = measured[MILLION]
    direct = MILLION**2 / (direct_rate("single") * 1e9)
    return [
        Figure("exponent of cost in N log N", float(exponent), "", "less", must=1.05, note=_spread(cost * 1e9)),
        Figure(
            what="Barnes–Hut, 1,000,000 bodies, angle 0.5, single",
            value=million.seconds,
            unit="s",
            better="less",
            peers={"direct, from its pairs a second": direct},
            must_beat={"direct, from its pairs a second": 20.0},
            note=f"one evaluation of all forces; {COUNTS[-1]:,} bodies take {memory:.1f} GB in all",
        ),
        Figure(
            what="rms relative error of its forces",
            value=million.error,
            unit="",
            better="less",
            must=1e-3,
            note=f"of {TARGETS} bodies by the direct sum in double precision",
        ),
    ]


def _measured(count: int) -> Measured:
    cloud = Cloud(count, precision="single", threads=None)
    x = plummer(count)
    spec = scene.Attraction(type="attraction", strength=1.0, softening=SOFTENING, opening_angle=ANGLE, method="tree")
    term = TreeAttraction(spec, cloud.points, (0,))
    cloud.fill(x, masses=1.0 / count)
    term.prepare(0.0)
    seconds = min(timed(lambda: term.prepare(0.0)) for _ in range(3))
    chosen = np.random.default_rng(1).choice(count, TARGETS, replace=False)
    found = cloud.of_slots(term.accelerations).T[chosen]
    exact = direct(x, chosen)
    errors = np.linalg.norm(found - exact, axis=1) / np.linalg.norm(exact, axis=1)
    return Measured(seconds, float(np.sqrt((errors**2).mean())))


def plummer(count: int) -> NDArray[np.float32]:
    """Positions of equal bodies in Plummer's sphere of scale length 1, without the outermost percent."""
    rng = np.random.default_rng(0)
    towards = rng.normal(size=(count, 3))
    radius = 1.0 / np.sqrt(rng.uniform(0.0, 0.99, count) ** (-2 / 3) - 1.0)
    return (towards * (radius / np.linalg.norm(towards, axis=1))[:, None]).astype(np.float32)


def direct(x: NDArray[np.float32], chosen: NDArray[np.int64]) -> Numbers:
    """Accelerations of the chosen ones by the sum over all."""
    sources = x.T.astype(np.float64)
    exact = np.empty((len(chosen), 3))
    for k, i in enumerate(chosen):
        d = sources - sources[:, i : i + 1]
        distance2 = (d**2).sum(axis=0) + SOFTENING**2
        exact[k] = d @ (distance2**-1.5) / len(x)
    return exact


def _spread(cost: Numbers) -> str:
    return f"{cost.min():.1f} to {cost.max():.1f} ns by N log₂ N, {COUNTS[0]:,} to {COUNTS[-1]:,} bodies"

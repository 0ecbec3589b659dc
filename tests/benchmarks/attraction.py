"""Attraction between every two of 16,384 bodies, summed up directly: ordered pairs a second."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from particlecli.scene.model import Scene
from particlecli.simulate import Simulation
from tests.benchmarks.contest import quickest, timed
from tests.benchmarks.figures import Figure
from tests.benchmarks.peers.cplusplus import library

Precision = Literal["single", "double"]

COUNT, FEW = 16_384, 2_048
"""Bodies; and those that NumPy gets, whose cost is the same for each pair."""

SOFTENING = 0.01
ROUNDS = 5
LEAST = {"single": 3.0, "double": 1.0}
"""Billions of ordered pairs a second."""

Numbers = NDArray[np.floating[Any]]


def measure() -> list[Figure]:
    """In both precisions, beside a loop in C++ that the compiler vectorizes, and NumPy."""
    return [_race("single"), _race("double")]


def direct_rate(precision: Precision) -> float:
    """Billions of ordered pairs a second, of ours alone."""
    work = _ours(precision, _bodies(precision))
    return COUNT**2 / min(timed(work) for _ in range(ROUNDS)) / 1e9


def _bodies(precision: Precision) -> Numbers:
    return np.random.default_rng(0).normal(size=(3, COUNT)).astype(np.float32 if precision == "single" else np.float64)


def _race(precision: Precision) -> Figure:
    bodies = _bodies(precision)
    ours = _ours(precision, bodies)
    contestants: dict[str, tuple[Callable[[], object], int]] = {"ours": (ours, COUNT), "NumPy": (_numpy(bodies), FEW)}
    if shutil.which("g++"):
        contestants["C++"] = (_cplusplus(precision, bodies), COUNT)
    seconds = quickest({name: work for name, (work, _) in contestants.items()}, ROUNDS)
    best = {name: count**2 / seconds[name] / 1e9 for name, (_, count) in contestants.items()}
    return Figure(
        what=f"attraction, {COUNT:,} bodies, {precision}",
        value=best.pop("ours"),
        unit="G pairs/s",
        better="more",
        must=LEAST[precision],
        peers=best,
        note="ordered pairs, a whole step of one evaluation; NumPy on fewer bodies",
    )


def _ours(precision: Precision, bodies: Numbers) -> Callable[[], object]:
    scene = Scene.model_validate(
        {
            "duration": 100,
            "fps": 100,
            "precision": precision,
            "particles": {"bodies": {"positions": bodies.T.tolist()}},
            "forces": [{"type": "attraction", "strength": 1 / COUNT, "softening": SOFTENING}],
            "integrator": {"type": "symplectic_euler", "dt": 0.01},
        }
    )
    system = Simulation(scene, fields={"bodies": frozenset()}).system
    system.advance(0.0)
    return lambda: system.advance(system.time + 0.01)


def _cplusplus(precision: Precision, bodies: Numbers) -> Callable[[], object]:
    rows = [np.array(row) for row in bodies] + [np.full(COUNT, 1 / COUNT, bodies.dtype)]
    rows += [np.empty(COUNT, bodies.dtype) for _ in range(3)]
    attract = getattr(library("attraction"), f"attract_{precision}")
    pointers = [ctypes.c_void_p(row.ctypes.data) for row in rows]
    # The rows live as long as the work does.
    return lambda: (attract(*pointers, ctypes.c_int64(COUNT), ctypes.c_double(SOFTENING**2)), rows)


def _numpy(bodies: Numbers) -> Callable[[], object]:
    x = bodies[:, :FEW]

    def work() -> Numbers:
        apart = x[:, None, :] - x[:, :, None]
        distance2 = (apart**2).sum(axis=0) + x.dtype.type(SOFTENING**2)
        pulls: Numbers = (apart / (distance2 * np.sqrt(distance2))).sum(axis=2)
        return pulls

    return work

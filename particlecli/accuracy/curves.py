"""The results of a study of error against time: runs, and what they tell when put together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from particlecli.accuracy.converged import Reference
from particlecli.accuracy.runs import Run, error_to_dict
from particlecli.runtime import Precision
from particlecli.scene.model import Scene

STEADY = 0.03
"""The largest error, in parts of how far particles go, that an order is read off."""

ABOVE_FLOOR = 8.0
"""The smallest, in floors."""

FINEST = 4
"""How many runs of a curve an order is read off, the finest of those between the two."""

VARIABLE_ORDER = ("SciPy LSODA",)
"""Integrators that change their order as they go."""

FALLS_NO_MORE = 0.6
"""A curve is on its floor where two more halvings of the step leave more than this share of the error."""


class Key(NamedTuple):
    """What the runs of a curve have in common."""

    integrator: str
    precision: Precision


@dataclass(frozen=True)
class WorkPrecision:
    """What a study came to.

    Attributes:
        scene: the scene.
        particles: by group, how many births were simulated, of how many there are.
        reference: what errors are measured by.
        runs: every integrator at every pace.
        no_peers: why there are no peers in the table; empty if there are.
        threads: worker threads of our integrators.
        frames_of: how many frames the scene has of which the first were looked at.
        left_out: integrators that there was no time for.
        seconds: wall time that all of it took.
    """

    scene: Scene
    particles: dict[str, tuple[int, int]]
    reference: Reference
    runs: tuple[Run, ...]
    no_peers: str
    threads: int
    frames_of: int
    left_out: tuple[str, ...]
    seconds: float

    @cached_property
    def known(self) -> float:
        """How well the reference is known, m: the least distance from it of a solution of another kind."""
        method = self.reference.method
        others = [run.error for run in self.runs if not method.startswith(run.integrator)]
        return min([self.reference.uncertainty.worst.p95, *others])

    @cached_property
    def orders(self) -> dict[tuple[str, Precision], float]:
        """By integrator and precision, the exponent with which the error falls with the number of steps."""
        extent, known = self.reference.extent, self.known
        fitted = {
            key: order(curve, max(known, floor_of(curve, extent) or 0.0), extent)
            for key, curve in curves(self.runs).items()
            if key.integrator not in VARIABLE_ORDER
        }
        return {(*key,): exponent for key, exponent in fitted.items() if exponent is not None}

    @cached_property
    def floors(self) -> dict[Precision, float]:
        """By precision, the error that roundoff leaves to the best integrator, m, where that was reached."""
        floors: dict[Precision, float] = {}
        for key, curve in curves([run for run in self.runs if not run.peer]).items():
            floor = floor_of(curve, self.reference.extent)
            if floor is not None and floor > 2.0 * self.known:
                floors[key.precision] = min(floor, floors.get(key.precision, math.inf))
        return floors

    @cached_property
    def front(self) -> list[Run]:
        """The runs that no other beats in both time and error, from the quickest to the most accurate."""
        return pareto(self.runs)

    @cached_property
    def metres_a_pixel(self) -> float | None:
        """How long a pixel is where errors are made, m; none where the camera sees no particle."""
        ratios = [run.error / run.error_pixels for run in self.runs if run.error_pixels]
        return float(np.median(ratios)) if ratios else None

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries, lists, strings and numbers."""
        return {
            "title": self.scene.title,
            "frames": self.scene.frame_count,
            "frames_of": self.frames_of,
            "left_out": list(self.left_out),
            "seconds": self.seconds,
            "fps": self.scene.fps,
            "threads": self.threads,
            "particles": {name: {"simulated": some, "of": total} for name, (some, total) in self.particles.items()},
            "error": "over the particles of a group and frame; of several groups the largest",
            "reference": {
                "method": self.reference.method,
                "compared_with": self.reference.second,
                "difference": error_to_dict(self.reference.uncertainty),
                "known_to_m": self.known,
                "particles_go_m": self.reference.extent,
            },
            "orders": [
                {"integrator": integrator, "precision": precision, "order": exponent}
                for (integrator, precision), exponent in self.orders.items()
            ],
            "roundoff_floor_m": self.floors,
            "metres_a_pixel": self.metres_a_pixel,
            "no_peers": self.no_peers or None,
            "runs": [run.to_dict() | {"on_pareto_front": run in self.front} for run in self.runs],
        }


def curves(runs: Sequence[Run]) -> dict[Key, list[Run]]:
    """The runs of each integrator and precision that reached the end, from few steps to many."""
    result: dict[Key, list[Run]] = {}
    for run in sorted(runs, key=lambda run: run.particle_steps):
        if run.deviation is not None:
            result.setdefault(Key(run.integrator, run.precision), []).append(run)
    return result


def on_floor(curve: Sequence[Run], extent: float) -> bool:
    """Whether the last two runs of a curve are hardly better than what went before, and all is small.

    Args:
        curve: runs, from few steps to many.
        extent: how far particles go, m.
    """
    errors = [run.error for run in curve]
    if len(errors) < 3 or min(errors) > STEADY * extent:
        return False
    return min(errors[-2:]) > FALLS_NO_MORE * min(errors[:-2])


def floor_of(curve: Sequence[Run], extent: float) -> float | None:
    """The smallest error of a curve if it has come to its floor, m."""
    return min(run.error for run in curve) if on_floor(curve, extent) else None


def order(curve: Sequence[Run], floor: float, extent: float) -> float | None:
    """The exponent with which the error falls with the number of steps; none where too few runs tell.

    Args:
        curve: runs, from few steps to many.
        floor: errors below which are not known or roundoff, m.
        extent: how far particles go, m.
    """
    telling = [run for run in curve if ABOVE_FLOOR * floor < run.error < STEADY * extent][-FINEST:]
    if len(telling) < 3:
        return None
    steps = np.log([run.particle_steps for run in telling])
    errors = np.log([run.error for run in telling])
    return float(-np.polyfit(steps, errors, 1)[0])


def pareto(runs: Sequence[Run]) -> list[Run]:
    """The runs that no other beats in both time and error, from the quickest to the most accurate."""
    front: list[Run] = []
    for run in sorted(runs, key=lambda run: (run.seconds, run.error)):
        if run.deviation is not None and (not front or run.error < front[-1].error):
            front.append(run)
    return front

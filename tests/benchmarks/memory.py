"""Bytes of state that a particle takes: what the plan says, and what the process grows by."""

from __future__ import annotations

import gc

import psutil

from particlecli.simulate import Simulation
from tests.benchmarks.dust import GROUP, Dust
from tests.benchmarks.figures import Figure

LARGEST = 32.0
"""Bytes."""


def measure() -> list[Figure]:
    """Bytes a particle of the dust."""
    few, many = Dust(count=16, frames=2), Dust(count=1 << 23, frames=2)
    keep = _advanced(few)
    before = _resident()
    simulation = _advanced(many)
    grown = _resident() - before
    planned = simulation.plan.groups[0].bytes_per_particle
    del keep
    return [
        Figure("state by the plan", planned, "B", "less", must=LARGEST),
        Figure(
            "growth of the process",
            grown / many.count,
            "B",
            "less",
            must=LARGEST,
            note=f"resident memory, {many.count:,} particles after a frame",
        ),
    ]


def _advanced(dust: Dust) -> Simulation:
    simulation = Simulation(dust.scene(), fields={GROUP: frozenset()})
    frames = iter(simulation)
    for _ in range(2):
        next(frames)
    return simulation


def _resident() -> int:
    gc.collect()
    return psutil.Process().memory_info().rss

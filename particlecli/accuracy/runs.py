"""One integrator at one pace on one scene: what it cost and how wrong it was."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from particlecli.accuracy.tracks import Deviation, Spread
from particlecli.runtime import Precision


@dataclass(frozen=True)
class Run:
    """One integrator at one pace.

    Attributes:
        integrator: its name.
        precision: of its numbers.
        steps, step: equal steps in a frame, and their length, s; none where it chooses its steps.
        tolerance: error tolerated in a step where it does.
        deviation: how far it is from the reference; none if it did not reach the end.
        energy_drift: see `EnergyDrift.of`.
        seconds: wall time of the simulation alone, s.
        evaluations: evaluations of the equations of motion, summed over all particles.
        particle_steps: steps, likewise.
        trouble: why it did not reach the end.
        peer: whether it is not one of ours.
        scaled: of a peer that ran on a sample of the particles: its time and counts are multiplied by this.
    """

    integrator: str
    precision: Precision
    steps: int | None
    step: float | None
    tolerance: float | None
    deviation: Deviation | None = None
    energy_drift: float | None = None
    seconds: float = 0.0
    evaluations: int = 0
    particle_steps: int = 0
    trouble: str = ""
    peer: bool = False
    scaled: float = 1.0

    @property
    def error(self) -> float:
        """The error that runs are ranked by, m: of 95 in 100 particles, at the worst frame."""
        return math.inf if self.deviation is None else self.deviation.worst.p95

    @property
    def error_pixels(self) -> float | None:
        """The same on the picture, pixels; none if no particle is seen there."""
        seen = None if self.deviation is None else self.deviation.worst_pixels
        return None if seen is None else seen.p95

    @property
    def pace(self) -> str:
        """The step or the tolerance, in words."""
        return f"tolerance {self.tolerance:.0e}" if self.step is None else f"{self.step:.3g} s"

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries and numbers."""
        return {
            "integrator": self.integrator,
            "peer": self.peer,
            "precision": self.precision,
            "steps_per_frame": self.steps,
            "step_s": self.step,
            "tolerance": self.tolerance,
            "error": None if self.deviation is None else error_to_dict(self.deviation),
            "energy_drift": self.energy_drift,
            "seconds": self.seconds,
            "evaluations": self.evaluations,
            "particle_steps": self.particle_steps,
            "particle_steps_per_second": self.particle_steps / self.seconds if self.seconds else None,
            "scaled_from_sample_by": self.scaled,
            "trouble": self.trouble or None,
        }


def error_to_dict(deviation: Deviation) -> dict[str, Any]:
    """Plain dictionaries and numbers; distances over the particles of a frame, m and pixels."""

    def numbers(spread: Spread | None) -> dict[str, float] | None:
        return None if spread is None else asdict(spread)

    return {
        "metres": {
            "final_frame": numbers(deviation.final),
            "worst_frame": numbers(deviation.worst),
        },
        "pixels": {
            "final_frame": numbers(deviation.final_pixels),
            "worst_frame": numbers(deviation.worst_pixels),
        },
        "unmatched_share": deviation.unmatched,
    }

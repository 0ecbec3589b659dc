"""All that a run tells of its own errors."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from particlecli.accuracy.conserved import Conserved
    from particlecli.accuracy.estimate import ErrorEstimate, GroupError
    from particlecli.frame import Frame


@dataclass(frozen=True)
class Accuracy:
    """What was found of a run's errors.

    Attributes:
        errors: by group, the estimated ones.
        left_out: groups of which an estimate would have been too dear, or that are too many together.
        drifts: by quantity that the forces between particles keep, how far it drifted.
    """

    errors: dict[str, GroupError] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
    drifts: dict[str, float] = field(default_factory=dict)


class Watch:
    """Watches a simulation for its errors; without anything to watch with, nothing is found."""

    def __init__(self, estimate: ErrorEstimate | None = None, conserved: Conserved | None = None) -> None:
        self._estimate, self._conserved = estimate, conserved

    def watch(self, frame: Frame) -> None:
        """Take note of a frame that the simulation has just made."""
        if self._estimate:
            self._estimate.watch(frame)
        if self._conserved:
            self._conserved.watch(frame)

    def result(self) -> Accuracy:
        """What was found; of a simulation at its end."""
        errors = self._estimate.result() if self._estimate else {}
        left_out = self._estimate.left_out if self._estimate else ()
        return Accuracy(errors, left_out, self._conserved.result() if self._conserved else {})

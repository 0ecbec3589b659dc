"""What `auto` came to: the scheme and pace that it chose for a scene, those that it did not, and why, in words."""

from __future__ import annotations

from dataclasses import dataclass

from particlecli.scene.integrator import Goal, Integrator, Scheme
from particlecli.scene.model import Scene

NEGLIGIBLE = 0.005
"""A share of the flights that is not worth a word."""


@dataclass(frozen=True)
class Tried:
    """A scheme that was considered.

    Attributes:
        scheme: its name.
        steps: equal steps in a frame; none for an adaptive scheme.
        tolerance: of an adaptive scheme.
        error: found by the pilots, in the unit asked for; none where none flew.
        cost: of a particle and frame, in evaluations of a scheme that works on packs.
        why: what spoke against it; empty for the one chosen.
    """

    scheme: Scheme
    steps: int | None
    tolerance: float | None
    error: float | None
    cost: float
    why: str

    @property
    def pace(self) -> str:
        """Its steps or its tolerance, in words."""
        if self.steps is None:
            return f"tolerance {self.tolerance:g}"
        return f"{self.steps} step{'s' if self.steps > 1 else ''} a frame"


@dataclass(frozen=True)
class Choice:
    """What was chosen for a scene, and what was not.

    Attributes:
        goal: the error asked for.
        chosen: what is known of the choice.
        rejected: the others, in the order in which they were considered.
        unseen: why pilots do not tell, if they do not.
        unknown: share of the flights of which nothing can be told, as the motion magnifies rounding there.
    """

    goal: Goal
    chosen: Tried
    rejected: tuple[Tried, ...] = ()
    unseen: str = ""
    unknown: float = 0.0

    @property
    def holds(self) -> bool:
        """Whether pilots found it to be as accurate as asked for."""
        return self.chosen.error is not None and self.chosen.error <= self.goal.size

    def lines(self) -> list[str]:
        """In words, what was chosen and what was not, and why."""
        goal, chosen = self.goal, self.chosen
        found = "" if chosen.error is None else f": pilots err by {chosen.error:.2g} {goal.unit}"
        return [
            f"auto chose {chosen.scheme}, {chosen.pace}{found}, {goal.size:g} {goal.unit} are allowed",
            *(f"  not {each.scheme}, {each.pace}: {each.why}" for each in self.rejected),
            *([f"  pilots do not tell: {self.unseen}; the run reports its error"] if self.unseen else []),
            *([_chaos(self.unknown)] if self.unknown > NEGLIGIBLE else []),
        ]


def _chaos(share: float) -> str:
    return f"  {share:.0%} of the flights are chaotic and count only until then: there no step keeps an error"


def integrator_of(scene: Scene, chosen: Tried) -> Integrator:
    """What to put in the place of a scene's `auto`."""
    own = scene.integrator
    step = None if chosen.steps is None else 1.0 / scene.fps / chosen.steps
    return Integrator(
        type=chosen.scheme,
        dt=own.dt if step is None else step,
        tolerance=chosen.tolerance,
        contact=own.contact,
        allow_unstable=own.allow_unstable,
    )

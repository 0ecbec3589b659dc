"""What a linear analysis tells of a scene: modes of motion, what it depends on, and the longest stable steps."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from particlecli.dynamics.integrators import SCHEMES
from particlecli.scene.integrator import Scheme
from particlecli.scene.model import Scene
from particlecli.stability.modes import Kind, Modes, kinds_of

SLIGHT = 0.1
"""Where rate times time is less than this, a dependence on position or velocity hardly shows."""

BOTH = 3.0
"""Where neither of two rates is so many times the other, both count."""

Ruler = Literal["nothing", "position", "velocity", "both", "flow"]


@dataclass(frozen=True)
class Limit:
    """How long a step may be.

    Attributes:
        step: s; infinite where nothing limits it, 0 where every step lets some mode grow.
        rate: of the mode that limits it, 1/s; none where nothing does.
        group: that has the mode.
    """

    step: float
    rate: complex | None
    group: str

    @classmethod
    def shortest(cls, limits: Iterable[Limit]) -> Limit:
        """The one that limits most."""
        shortest = min(limits, key=lambda limit: limit.step, default=None)
        return cls(math.inf, None, "") if shortest is None or shortest.step == math.inf else shortest


@dataclass(frozen=True)
class GroupAnalysis:
    """The motion of a group, linearized about the states of its particles.

    Attributes:
        name: of the group.
        newtonian: whether it is moved by forces, or carried by a flow.
        particles, sampled: how many there are, and how many were looked at; those that sit in a singularity,
            where nothing can be linearized, are not among them.
        linear: whether the motion is linear, so that what holds at one state holds everywhere.
        span: how long a particle moves, s: the scene's duration or a shorter life.
        acceleration: median of its size, m/s²; of a first-order group the speed, m/s.
        position_rate, velocity_rate: the square root of the largest |∂a/∂x| and the largest |∂a/∂v|, 1/s;
            of a first-order group the largest |∂u/∂x| and zero.
        modes: of all sampled particles, shape (m,).
        limits: the longest stable step of each scheme that the scene could use.
        coupled: whether the particles act on each other, so that modes are those of all of them together.
        complete: whether these are all modes; else they are the fastest of each kind.
    """

    name: str
    newtonian: bool
    particles: int
    sampled: int
    linear: bool
    span: float
    acceleration: float
    position_rate: float
    velocity_rate: float
    modes: Modes
    limits: dict[Scheme, Limit]
    coupled: bool = False
    complete: bool = True

    @property
    def ruler(self) -> Ruler:
        """What the motion depends on most: position, velocity, both, a flow, or nothing."""
        position, velocity = self.position_rate, self.velocity_rate
        if max(position, velocity) * self.span < SLIGHT:
            return "nothing"
        if not self.newtonian:
            return "flow"
        if max(position, velocity) < BOTH * min(position, velocity):
            return "both"
        return "velocity" if velocity > position else "position"

    def of_kind(self, kind: Kind) -> Modes:
        """The modes that are of a kind."""
        return self.modes.at(kinds_of(self.modes.rates) == kind)


@dataclass(frozen=True)
class Analysis:
    """The linear analysis of a scene.

    Attributes:
        scene: the scene.
        time: of the state, s; at 0 the particles of emitters are looked at as they are born.
        step: that the scene's integrator takes, s; none where it chooses its own.
        groups: the groups that have particles then.
    """

    scene: Scene
    time: float
    step: float | None
    groups: tuple[GroupAnalysis, ...]

    @property
    def limits(self) -> dict[Scheme, Limit]:
        """The longest step of each scheme, that the scene could use, at which all groups are stable."""
        schemes = [scheme for scheme in SCHEMES if all(scheme in group.limits for group in self.groups)]
        return {s: Limit.shortest(group.limits[s] for group in self.groups) for s in schemes}

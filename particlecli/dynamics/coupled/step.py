"""What a pack of coupled particles does in a step."""

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.ending import Ending
from particlecli.dynamics.coupled.impacts import CoupledImpacts
from particlecli.dynamics.coupled.motion import CoupledMotion
from particlecli.dynamics.coupled.stages import Stages

HOPELESS = 1e30
"""The error of a step that led to no number."""


@ti.data_oriented
class Step:
    """A step, pack by pack: all packs `begin`; for each evaluation all `evaluate`, then all `follow`; all `finish`.

    Args:
        motion: the accelerations.
        stages: the scheme.
        ending: what happens besides motion.

    Attributes:
        impacts: what happens at planes within the step, if any are met so.
        locates: whether they are.
        eventful: whether anything happens at the end of a step besides motion.
        reuses: whether the last accelerations of a step are the first of the next.
        times: of the evaluations, and of the end, in steps.
    """

    def __init__(self, motion: CoupledMotion, stages: Stages, ending: Ending) -> None:
        self.motion = motion
        self.points = motion.points
        self.real = motion.points.real
        self.stages = stages
        self.ending = ending
        self.locates = bool(ending.located)
        self.impacts = CoupledImpacts(ending) if self.locates else None
        self.evaluations = len(stages.times)
        self.eventful = ending.needed or any(term.ends_steps for term in motion.terms)
        self.reuses = stages.repeats and not self.eventful
        self.times = self.points.memory.table(self.real, np.array([*stages.times, 1.0]))

    @ti.func
    def begin(self, b, t0, now, h):
        """At the beginning of a step of length h from `now`, s after t0, when the frame began."""
        self.ending.pins.place(b, t0 + now)
        self.stages.begin(b)
        self.ending.begin(b, now, h)

    @ti.func
    def evaluate(self, i, b, t):
        """Evaluation i, at time t, s; where impacts are located, of −1 and of the end, as if there were no planes."""
        a = self.motion.acceleration(b, t)
        if ti.static(not self.locates):
            self.stages.keep(i, b, a)
        elif (i >= 0) & (i < self.evaluations):
            self.stages.keep(i, b, self.impacts.footing.held(b, a))
        else:
            self.impacts.footing.keep(b, a)

    @ti.func
    def follow(self, i, b, t, h):
        """On to the next stage after evaluation i, in a step of length h from time t."""
        self.stages.follow(i, b, self.ending.reaches[b])
        self.ending.pins.place(b, t + self.times[i + 1] * h)

    @ti.func
    def revert(self, b):
        """Back to the beginning of the step."""
        for c in ti.static(range(6)):
            self.points.state[c, b] = self.stages.base[c, b]

    @ti.func
    def error(self, b, tolerance):
        """The largest error of the particles of a pack, 1 being tolerated."""
        reach = self.ending.reaches[b]
        errors = self.stages.error(b, reach, tolerance)
        counted = ti.select(reach > 0.0, ti.select(errors < HOPELESS, errors, HOPELESS), 0.0)
        return counted.max()

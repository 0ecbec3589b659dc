"""Particles of coupled groups that meet planes, one by one."""

import taichi as ti

from particlecli.dynamics.coupled.ending import Ending


@ti.data_oriented
class PlaneLanes:
    """Access to particles by pack b of points and lane, in groups of which impacts are located.

    Args:
        ending: of steps; its groups, points and states at the beginning of the step.

    Attributes:
        events: of each group, at its planes.
        motions: of each group, where planes hold particles.
    """

    def __init__(self, ending: Ending) -> None:
        self.ending = ending
        self.points = ending.points
        self.groups = ending.groups
        self.located = ending.located
        self.events = [group.march.careful_stepper.events for group in self.groups]
        self.motions = [group.march.careful_stepper.motion for group in self.groups]

    @ti.func
    def state(self, b, lane):
        """x, y, z, u, v, w."""
        return [self.points.state[c, b][lane] for c in ti.static(range(6))]

    @ti.func
    def fate(self, g: ti.template(), b, lane):
        """The fate, 0 where nothing can die or stick."""
        fate = 0
        if ti.static(self.groups[g].has("fate")):
            row = ti.static(self.groups[g].state.row("fate"))
            fate = self.groups[g].state.integers[row, b - self.points.firsts[g]][lane]
        return fate

    @ti.func
    def put(self, g: ti.template(), b, lane, state, fate):
        """Replace state and fate."""
        for c in ti.static(range(6)):
            self.points.state[c, b][lane] = state[c]
        if ti.static(self.groups[g].has("fate")):
            row = ti.static(self.groups[g].state.row("fate"))
            self.groups[g].state.integers[row, b - self.points.firsts[g]][lane] = fate

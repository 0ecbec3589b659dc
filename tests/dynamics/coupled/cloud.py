"""Coupled particles set up from arrays, without a scene around them."""

import numpy as np
import taichi as ti

from particlecli import runtime
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.memory import FieldMemory

LANES = 16


class Cloud:
    """Points with room for so many particles in each group, filled from arrays again and again."""

    def __init__(self, *rooms, precision="double", threads=1):
        runtime.start(precision, threads)
        memory = FieldMemory()
        self.points = Points({f"group{g}": room for g, room in enumerate(rooms)}, _real(precision), memory)
        self.views = memory.view(self.points.state), memory.view(self.points.mass)
        self.slots = np.zeros(0, np.int64)

    def fill(self, *groups, masses=1.0, velocities=None):
        """Put positions, shape (n, 3), into each group; masses and velocities for all groups one after the other."""
        self.points.arrange([len(group) for group in groups])
        starts = self.points.first_packs * LANES
        self.slots = np.concatenate([starts[g] + np.arange(len(group)) for g, group in enumerate(groups)])
        positions = np.concatenate(groups)
        columns = np.zeros((7, self.points.capacity * LANES), self.points.real_dtype)
        columns[:3, self.slots] = positions.T
        columns[3:6, self.slots] = 0.0 if velocities is None else velocities.T
        columns[6, self.slots] = masses
        packs = columns.reshape(7, -1, LANES)
        state, mass = self.views
        state.array[:], mass.array[:] = packs[:6], packs[6]
        self.points.memory.open()

    def of_slots(self, field):
        """The values of a field of packs for each particle, the last axis."""
        values = field.to_numpy()
        return values.reshape(*values.shape[:-2], -1)[..., self.slots]


def accelerations(term, cloud):
    """Of each particle, m/s², shape (n, 3), as the present contents of the points have it."""
    cloud.points.memory.open()
    term.restart()
    term.rearranged()
    term.prepare(0.0)
    return summed(term, cloud)


def summed(term, cloud):
    """What a local force found when it prepared last: accelerations, m/s², shape (n, 3)."""
    rows = cloud.of_slots(term.neighbors.rows.place)
    return term.accelerations.to_numpy()[rows, :3]


def energy(term, cloud):
    """The potential energy, J."""
    cloud.points.memory.open()
    term.rearranged()
    term.prepare_potential(0.0)
    return cloud.of_slots(term.energies).sum()


def _real(precision):
    return ti.f64 if precision == "double" else ti.f32

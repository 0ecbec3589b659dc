"""The equations of motion of all particles that act on each other, as functions of their coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from particlecli.dynamics.masses import masses
from particlecli.errors import SimulationError
from particlecli.stability.modes import Doubles
from particlecli.stability.springs import held

if TYPE_CHECKING:
    from particlecli.dynamics.system import System

NEAR = 0.01
"""This part of the particles have a neighbour nearer than what counts as the distance between neighbours."""

FINE, COARSE = 1e-5, 3e-4
"""Steps of differences that are right to their second and to their fourth order, in parts of that distance."""


class CoupledMotion:
    """Accelerations of the coupled particles of a system about their present state.

    Coordinates are √m x, of those particles that are not pinned: in them the Jacobian of forces that have a potential
    is symmetric. The Jacobians are differences of what the kernels of the run compute.

    Args:
        system: in double precision; its coupled particles are left anywhere near where they were.

    Attributes:
        names: of the groups.
        particles: how many particles there are.
        size: how many coordinates.
        acceleration: median of its size, m/s².
        damped: whether accelerations depend on velocities.

    Raises:
        SimulationError: accelerations are not finite.
    """

    def __init__(self, system: System) -> None:
        assert system.coupled is not None
        self._coupled, self._time = system.coupled, system.time
        self._groups = {name: group for name, group in system.groups.items() if group.plan.coupled}
        self.names = tuple(name for name, group in self._groups.items() if group.state.count)
        counts = [group.state.count for group in self._groups.values()]
        self._ends = np.cumsum(counts)[:-1]
        self.particles = sum(counts)
        self._state = np.concatenate(
            [group.state.read(group.plan.motion_components).astype(float) for group in self._groups.values()], axis=1
        )
        ids = system.frame(0, {}).groups
        weights = [masses(group.plan, ids[name].ids) for name, group in self._groups.items()]
        pinned = [
            held(group.plan) if group.plan.pins else np.zeros(group.state.count, bool)
            for group in self._groups.values()
        ]
        self._free = ~np.concatenate(pinned)
        self._roots = np.repeat(np.sqrt(np.concatenate(weights)[self._free]), 3)
        self.size = len(self._roots)
        terms = [*self._coupled.terms, *(force for group in self._groups.values() for force in group.motion.forces)]
        self.damped = any(term.depends_on_velocity for term in terms)
        self._distance, self._speed = self._scales(1.0 / system.plan.scene.fps)
        self.acceleration = self._median()

    def _scales(self, interval: float) -> tuple[float, float]:
        """Over which lengths, m, and speeds, m/s, forces change."""
        positions, speeds = self._state[:3].T, np.linalg.norm(self._state[3:], axis=0)
        apart = cKDTree(positions).query(positions, k=2)[0][:, 1] if self.particles > 1 else np.empty(0)
        apart = apart[(apart > 0.0) & np.isfinite(apart)]
        distance = float(np.quantile(apart, NEAR)) if len(apart) else 1.0
        return distance, max(float(np.median(speeds)) if self.particles else 0.0, distance / interval)

    def _median(self) -> float:
        if not self.size:
            return 0.0
        here = self._accelerations(np.zeros(self.size), np.zeros(self.size)) / self._roots
        if not np.isfinite(here).all():
            raise SimulationError(f"accelerations are not finite at t = {self._time:g} s, so there are no modes")
        return float(np.median(np.linalg.norm(here.reshape(-1, 3), axis=1)))

    def along(self, shift: Doubles, push: Doubles) -> Doubles:
        """J y + G w, where J = ∂a/∂x and G = ∂a/∂v in these coordinates.

        Args:
            shift, push: y and w, shape (size,).
        """
        largest = max(
            float(np.max(np.abs(shift / self._roots), initial=0.0)) / self._distance,
            float(np.max(np.abs(push / self._roots), initial=0.0)) / self._speed,
        )
        if largest == 0.0:
            return np.zeros(self.size)
        step = FINE / largest
        both = [self._accelerations(sign * step * shift, sign * step * push) for sign in (1.0, -1.0)]
        return np.asarray((both[0] - both[1]) / (2.0 * step))

    def by_position(self) -> Doubles:
        """J, 1/s², shape (size, size)."""
        rest, columns = np.zeros(self.size), np.empty((self.size, self.size))
        for k, root in enumerate(self._roots):
            shift = np.zeros(self.size)
            shift[k] = COARSE * self._distance * root
            near, far = (
                self._accelerations(s * shift, rest) - self._accelerations(-s * shift, rest) for s in (1.0, 2.0)
            )
            columns[:, k] = (8.0 * near - far) / (12.0 * shift[k])
        return columns

    def by_velocity(self) -> Doubles:
        """G, 1/s, shape (size, size)."""
        return np.stack([self.along(np.zeros(self.size), unit) for unit in np.eye(self.size)], axis=1)

    def _accelerations(self, shift: Doubles, push: Doubles) -> Doubles:
        """√m a where coordinates and their rates are so much larger than they are, shape (size,)."""
        moved = self._state.copy()
        moved[:3, self._free] += (shift / self._roots).reshape(-1, 3).T
        moved[3:, self._free] += (push / self._roots).reshape(-1, 3).T
        for group, rows in zip(self._groups.values(), np.split(moved, self._ends, axis=1), strict=True):
            group.state.overwrite(group.plan.motion_components, rows)
        slopes = self._coupled.derivative(self._time)
        together = np.concatenate([slopes[name][3:] for name in self._groups], axis=1)
        return np.asarray(together[:, self._free].T.ravel() * self._roots)

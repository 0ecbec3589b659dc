"""Groups at rest in a coordinate frame: no equations of motion, no state, no kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.births import ParticleBirths
from particlecli.frame import Floats, GroupFrame
from particlecli.scene.frames import chain
from particlecli.scene.model import Scene
from particlecli.scene.poses import Poses


class FixedGroup:
    """The particles of a group that moves with its frame alone.

    Attributes:
        count: how many.

    Raises:
        SceneError: the group's file cannot be used.
    """

    def __init__(self, scene: Scene, name: str) -> None:
        births = ParticleBirths(scene, name)
        self.count = births.total
        self._table = births.table(0, births.total)
        self._ride = chain(scene.frames, scene.particles[name].frame)
        self._single = scene.precision == "single"

    def frame(self, time: float, fields: frozenset[str]) -> GroupFrame:
        """The particles at a time, s; `fields` are the optional arrays wanted."""
        poses = Poses.of(self._ride, np.array([time]))
        local, heat = self._table.positions, self._table.temperatures
        return GroupFrame(
            ids=self._table.ids,
            positions=self._rounded(poses.points(local)).T,
            velocities=self._rounded(poses.velocities(local)).T if "velocities" in fields else None,
            ages=self._rounded(np.full(self.count, time)) if "ages" in fields else None,
            temperatures=self._rounded(heat) if heat is not None and "temperatures" in fields else None,
        )

    def _rounded(self, values: NDArray[np.float64]) -> Floats:
        return values.astype(np.float32) if self._single else values

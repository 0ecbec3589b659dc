"""What particles are born with, and when; it depends on the seed, the group and the birth index alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.birth_table import BirthTable, cooling_rates, differing, placed, present
from particlecli.dynamics.birth_times import BirthTimes
from particlecli.dynamics.kin import Brood, Parents
from particlecli.dynamics.layouts import arrangement, layout_count, layout_positions
from particlecli.dynamics.particle_files import ParticleList
from particlecli.dynamics.random import Array, Draw, Draws, sample
from particlecli.dynamics.shapes import directions, points
from particlecli.errors import Problem, SceneError
from particlecli.scene.distributions import Distribution, support
from particlecli.scene.expression import Expression
from particlecli.scene.frames import Chain, chain
from particlecli.scene.groups import Emitter
from particlecli.scene.model import Scene
from particlecli.scene.poses import Poses

AHEAD = 4096
"""Births that are drawn at once where fewer are asked for."""


class EmitterBirths:
    """The births of an emitter; each at the pose that the emitter's frame has at its instant.

    Attributes:
        total: number of births until the end of the scene.
        has_masses: whether masses differ.
        has_temperature: whether particles have a temperature.
        hottest: no particle is hotter when born, K; None without temperature.

    Raises:
        SimulationError: the rate is not finite at some time, or more would be born than a group can hold.
    """

    def __init__(self, scene_seed: int, name: str, emitter: Emitter, duration: float, ride: Chain = ()) -> None:
        """`ride` leads from the world to the emitter's frame."""
        self._seed, self._name, self._emitter, self._ride = scene_seed, name, emitter, ride
        self._times = BirthTimes(name, emitter, duration)
        self.total = self._times.total
        self.has_masses = isinstance(emitter.mass, Distribution)
        self.has_temperature = emitter.temperature is not None
        self.hottest = None if emitter.temperature is None else support(emitter.temperature)[1]
        self._since, self._drawn = np.inf, self.table(0, 0)

    def between(self, after: float, until: float) -> BirthTable:
        """The births at after < t ≤ until, s; the first span begins at −inf.

        Some more are drawn and kept, for spans follow each other and the work for a few births is mostly overhead.
        """
        if not self._have(after, until):
            first, last = (int(index) for index in self._times.until(np.array([after, until])))
            self._since, self._drawn = after, self.table(first, min(max(last, first + AHEAD), self.total))
        first, last = np.searchsorted(self._drawn.times, [after, until], side="right")
        return self._drawn.rows(np.arange(first, last))

    def _have(self, after: float, until: float) -> bool:
        """Whether all births of a span are drawn."""
        drawn = self._drawn
        if after < self._since or not len(drawn):
            return False
        return until < float(drawn.times[-1]) or int(drawn.ids[-1]) + 1 == self.total

    def table(self, first: int, last: int) -> BirthTable:
        """The births with indices from `first` to `last` − 1, within 0 and `total`."""
        return self.of(np.arange(first, last))

    def of(self, ids: NDArray[np.int64]) -> BirthTable:
        """The births with these indices, in their order; nothing is drawn for others."""
        emitter = self._emitter
        draws = Draws(self._seed, self._name, ids)
        times = self._times.of(ids)
        positions, velocities = points(emitter.shape, draws), self._velocities(draws)
        if self._ride:
            positions, velocities = placed(Poses.of(self._ride, times), emitter, positions, velocities)
        return self._table(ids, draws, times, positions, velocities)

    def _table(
        self, ids: NDArray[np.int64], draws: Draws, times: Array, positions: Array, velocities: Array | None
    ) -> BirthTable:
        emitter = self._emitter
        return BirthTable(
            ids=ids,
            times=times,
            positions=positions,
            velocities=velocities,
            masses=differing(emitter.mass, draws, Draw.MASS),
            lifetimes=present(emitter.lifetime, draws, Draw.LIFETIME),
            temperatures=present(emitter.temperature, draws, Draw.TEMPERATURE),
            cooling_rates=cooling_rates(emitter, draws),
        )

    def of_parents(self, brood: Brood, parents: Parents) -> BirthTable:
        """Births where and when parents are, in the order of their instants."""
        order = np.argsort(parents.times, kind="stable")
        ids = brood.numbers(parents.ids, parents.places)[order]
        emitter, draws = self._emitter, Draws(self._seed, self._name, ids)
        velocities = self._velocities(draws)
        if velocities is not None:
            velocities += brood.rule.inherit_velocity * parents.velocities[:, order]
        positions = points(emitter.shape, draws) + parents.positions[:, order]
        return self._table(ids, draws, parents.times[order], positions, velocities)

    def largest_population(self, longest_life: float | None, interval: float) -> int:
        """How many can be alive at once, together with those born within an interval; never too small.

        Args:
            longest_life: s; None: nobody dies of age.
            interval: s, from one removal of the dead to the next.
        """
        return self._times.largest_population(longest_life, interval)

    def _velocities(self, draws: Draws) -> Array | None:
        if self._emitter.motion == "first_order":
            return None
        return directions(self._emitter.direction, draws) * sample(self._emitter.speed, draws, Draw.SPEED)


class ParticleBirths:
    """The particles of a group that is there at t = 0; a file is read at once, all else when asked for.

    Attributes:
        total: number of particles.
        has_masses: whether masses differ.
        has_temperature: whether particles have a temperature, from the scene or from the file.
        hottest: no particle is hotter when born, K; None without temperature.

    Raises:
        SceneError: the group's file cannot be used.
    """

    def __init__(self, scene: Scene, name: str) -> None:
        self._seed, self._name, self._group = scene.seed, name, scene.particles[name]
        group = self._group
        self._ride = chain(scene.frames, group.frame)
        self._source = arrangement(name, group, scene.folder)
        self.has_masses = isinstance(group.mass, Distribution)
        self.hottest = None if group.temperature is None else support(group.temperature)[1]
        if isinstance(self._source, ParticleList):
            self.total = len(self._source)
            self.has_masses |= self._source.masses is not None
            if self._source.temperatures is not None:
                self.hottest = float(self._source.temperatures.max())
        else:
            self.total = layout_count(self._source)
        self.has_temperature = self.hottest is not None

    def table(self, first: int, last: int) -> BirthTable:
        """The particles with indices from `first` to `last` − 1, within 0 and `total`."""
        return self._table(np.arange(first, last), slice(first, last))

    def of(self, ids: NDArray[np.int64]) -> BirthTable:
        """The particles with these indices, in their order."""
        return self._table(ids, ids)

    def _table(self, ids: NDArray[np.int64], places: slice | NDArray[np.int64]) -> BirthTable:
        group = self._group
        draws = Draws(self._seed, self._name, ids)
        if isinstance(self._source, ParticleList):
            given = self._source.part(places)
        else:
            given = ParticleList(positions=layout_positions(self._source, draws))
        masses = differing(group.mass, draws, Draw.MASS)
        temperatures = present(group.temperature, draws, Draw.TEMPERATURE)
        positions, velocities = given.positions, self._velocities(given, draws)
        if self._ride and group.motion != "fixed":
            positions, velocities = placed(Poses.of(self._ride, np.zeros(1)), group, positions, velocities)
        return BirthTable(
            ids=ids,
            times=np.zeros(len(ids)),
            positions=positions,
            velocities=velocities,
            masses=masses if given.masses is None else given.masses,
            lifetimes=present(group.lifetime, draws, Draw.LIFETIME),
            temperatures=temperatures if given.temperatures is None else given.temperatures,
            cooling_rates=cooling_rates(group, draws),
        )

    def _velocities(self, given: ParticleList, draws: Draws) -> Array | None:
        if self._group.motion != "newtonian":
            return None
        if given.velocities is not None:
            return given.velocities
        if self._group.velocity is None:
            return np.zeros((3, len(draws)))
        axes = zip(self._group.velocity, (Draw.VELOCITY_X, Draw.VELOCITY_Y, Draw.VELOCITY_Z), strict=True)
        found = np.stack([_component(component, given.positions, draws, draw) for component, draw in axes])
        if not np.isfinite(found).all():
            message = f"is not finite where particle {draws.indices[~np.isfinite(found).all(axis=0)][0]} begins"
            raise SceneError([Problem(f"particles.{self._name}.velocity", message)])
        return found


class SampledBirths:
    """Some of the births of a group; they keep their numbers, instants and all they are born with.

    Attributes:
        births: the group's births.
        ids: which of them.
        total: how many of them.
        has_masses, has_temperature, hottest: as of `EmitterBirths`.
    """

    def __init__(self, births: Births, ids: NDArray[np.int64]) -> None:
        self.births = births
        self.ids = ids
        self.total = len(ids)
        self.has_masses: bool = births.has_masses
        self.has_temperature: bool = births.has_temperature
        self.hottest: float | None = births.hottest
        self._table = births.of(ids)

    def between(self, after: float, until: float) -> BirthTable:
        """Those at after < t ≤ until, s."""
        first, last = np.searchsorted(self._table.times, [after, until], side="right")
        return self.table(int(first), int(last))

    def table(self, first: int, last: int) -> BirthTable:
        """Those from the place `first` in the sample to the place `last` − 1."""
        return self._table.rows(np.arange(first, last))

    def of(self, ids: NDArray[np.int64]) -> BirthTable:
        """The births with these numbers, in their order, whether in the sample or not."""
        return self.births.of(ids)


Births = EmitterBirths | ParticleBirths | SampledBirths


def _component(value: float | Distribution | Expression, positions: Array, draws: Draws, draw: Draw) -> Array:
    if isinstance(value, Expression):
        with np.errstate(all="ignore"):
            values = value.evaluate(dict(zip("xyz", positions, strict=True)))
        return np.broadcast_to(values, len(draws)).astype(np.float64)
    return sample(value, draws, draw)

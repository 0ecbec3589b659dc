"""Children of particles: found where and when their parents are, after each interval."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.birth_table import BirthTable
from particlecli.dynamics.births import Births, EmitterBirths
from particlecli.dynamics.deaths import Fate
from particlecli.dynamics.group import Group
from particlecli.dynamics.kin import Brood, Parents
from particlecli.dynamics.random import Array


class Offspring:
    """What the particles of one group bear.

    Args:
        group: the parents.
        broods: their rules.
        births: of all groups.
    """

    def __init__(self, group: Group, broods: Sequence[Brood], births: Mapping[str, Births]) -> None:
        self._group = group
        self._broods = broods
        self._births = births
        self._on_the_way = any(brood.rule.on == "way" for brood in broods)
        self._before = np.empty((7, 0))
        self._struck = np.empty(0, np.int64)

    def begin(self) -> None:
        """Note where the parents are before an interval."""
        self._before = self._state() if self._on_the_way else self._ages()
        if self._group.impacts:
            self._struck = self._impacts()

    def born(self, start: float) -> Iterator[tuple[str, BirthTable]]:
        """Children of the interval that began at a time, s, group by group; before the dead are removed."""
        state = self._group.state
        fates = state.read(("fate",))[0] if self._group.has("fate") else np.zeros(state.count, np.int32)
        ids = state.read(("id",))[0].astype(np.int64)
        now = self._state()
        for brood in self._broods:
            match brood.rule.on:
                case "death":
                    parents = self._dying(brood, ids, fates, now, start)
                case "impact":
                    parents = self._striking(brood, ids)
                case "way":
                    parents = self._on_their_way(brood, ids, now, start)
            births = self._births[brood.child]
            assert isinstance(births, EmitterBirths)
            yield brood.child, births.of_parents(brood, parents)

    def _ages(self) -> Array:
        return self._group.state.read(("age",)).astype(np.float64)

    def _state(self) -> Array:
        """Age, position and velocity of each parent, shape (7, n)."""
        motion = self._group.state.read(self._group.plan.motion_components).astype(np.float64)
        still = np.zeros((6 - len(motion), motion.shape[1]))
        return np.concatenate([self._ages(), motion, still])

    def _dying(
        self, brood: Brood, ids: NDArray[np.int64], fates: NDArray[np.int32], now: Array, start: float
    ) -> Parents:
        dead = fates > 0
        at_death = now[:, dead]
        times = start + (at_death[0] - self._before[0, dead])
        expired = fates[dead] == int(Fate.EXPIRED)
        if expired.any():
            times[expired] = self._ends(ids[dead][expired], times[expired])
        each = brood.each
        return Parents(
            ids=np.repeat(ids[dead], each),
            places=np.tile(np.arange(each), np.count_nonzero(dead)),
            times=np.repeat(times, each),
            positions=np.repeat(at_death[1:4], each, axis=1),
            velocities=np.repeat(at_death[4:7], each, axis=1),
        )

    def _ends(self, ids: NDArray[np.int64], times: Array) -> Array:
        """When lifetimes end, s: exactly for particles without parents, else as the state tells."""
        births = self._births[self._group.plan.name]
        own = ids < births.total
        table = births.of(ids[own])
        assert table.lifetimes is not None
        exact = times.copy()
        exact[own] = table.times + table.lifetimes
        return exact

    def _striking(self, brood: Brood, ids: NDArray[np.int64]) -> Parents:
        record, count = self._group.impacts, brood.rule.count
        assert record is not None
        assert count is not None
        before = np.minimum(self._struck, brood.rule.impacts)
        several = np.minimum(self._impacts(), brood.rule.impacts) - before
        slots, numbers = _runs(before, several)
        found = np.repeat(record.read(slots, numbers), count, axis=1)
        places = np.repeat(numbers * count, count) + np.tile(np.arange(count), len(slots))
        return Parents(
            ids=np.repeat(ids[slots], count),
            places=places,
            times=found[0],
            positions=found[1:4],
            velocities=found[4:7],
        )

    def _impacts(self) -> NDArray[np.int64]:
        return np.asarray(self._group.state.read(("impacts",))[0], np.int64)

    def _on_their_way(self, brood: Brood, ids: NDArray[np.int64], now: Array, start: float) -> Parents:
        rate = brood.rule.rate
        assert rate is not None
        before = self._before
        first = np.floor(np.maximum(before[0], 0.0) * rate + 0.5).astype(np.int64)
        end = np.floor(np.maximum(now[0], 0.0) * rate + 0.5).astype(np.int64)
        counts = np.clip(np.minimum(end, brood.each) - first, 0, None)
        rows, places = _runs(first, counts)
        ages = (places + 0.5) / rate
        begin, finish = np.maximum(before[0, rows], 0.0), now[0, rows]
        positions, velocities = _between(before[1:, rows], now[1:, rows], ages - begin, finish - begin)
        return Parents(
            ids=ids[rows],
            places=places,
            times=start + (ages - before[0, rows]),
            positions=positions,
            velocities=velocities,
        )


def _runs(first: NDArray[np.int64], counts: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """For each row as many numbers as `counts` says, from `first` on: the rows, and the numbers."""
    rows = np.repeat(np.arange(len(counts)), counts)
    return rows, np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts) + first[rows]


def _between(first: Array, last: Array, elapsed: Array, interval: Array) -> tuple[Array, Array]:
    """Positions and velocities by the cubic that has both states, each (6, n), at the ends of an interval, s."""
    s = elapsed / interval
    way = last[:3] - first[:3]
    begin, end = interval * first[3:], interval * last[3:]
    square, cubic = 3 * way - 2 * begin - end, begin + end - 2 * way
    positions = first[:3] + s * (begin + s * (square + s * cubic))
    return positions, (begin + s * (2 * square + 3 * s * cubic)) / interval

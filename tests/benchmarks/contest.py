"""Contest: ours and its peers advance the same particles in turn, frame by frame, and feel the same noise."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from particlecli.simulate import Simulation
from tests.benchmarks.dust import FPS, GROUP, Dust

State = NDArray[np.float32]
"""Rows x, y, z, u, v, w of all particles."""


class Contestant(Protocol):
    """Something that advances particles."""

    def restart(self) -> None:
        """Put all particles back to where they began."""

    def advance(self) -> None:
        """Advance all particles by a frame."""

    def state(self) -> State:
        """Where the particles are now, shape (6, count)."""


Peer = Callable[[Dust, State], Contestant]
"""Makes a contestant of given particles."""


class Ours:
    """A `Simulation`, advanced from frame to frame as it advances itself, its frames copied to nobody."""

    def __init__(self, dust: Dust) -> None:
        self.simulation = Simulation(dust.scene(), fields={GROUP: frozenset()})
        self.simulation.system.advance(0.0)
        self._start = self.simulation.system.get_state()
        self._frame = 0

    def restart(self) -> None:
        """Put all particles back to where they began."""
        self._frame = 0
        self.simulation.system.time = 0.0
        self.simulation.system.set_state(self._start)

    def advance(self) -> None:
        """Advance all particles by a frame."""
        self._frame += 1
        self.simulation.system.advance(self._frame / FPS)

    def state(self) -> State:
        """Where the particles are now."""
        return self.simulation.system.get_state().reshape(6, -1).astype(np.float32)


@dataclass(frozen=True)
class Result:
    """How a contestant did.

    Attributes:
        rate: particle-steps a second; of each frame the fastest go counts, for noise only ever adds time.
        apart: share of the particles that end more than a millimetre from where ours are.
    """

    rate: float
    apart: float


def contest(dust: Dust, peers: Mapping[str, Peer], goes: int = 3) -> dict[str, Result]:
    """Every contestant from the same particles through all frames, several times, in turn frame by frame."""
    ours = Ours(dust)
    start = ours.state()
    contestants: dict[str, Contestant] = {"ours": ours}
    contestants |= {name: make(dust, start) for name, make in peers.items()}
    seconds = {name: np.empty((goes, dust.frames)) for name in contestants}
    for go in range(goes):
        for contestant in contestants.values():
            contestant.restart()
        for frame in range(dust.frames):
            for name in _in_turn(list(contestants), go + frame):
                seconds[name][go, frame] = timed(contestants[name].advance)
    end = ours.state()
    return {
        name: Result(
            rate=dust.particle_steps * dust.frames / float(times.min(axis=0).sum()),
            apart=_apart(end, contestants[name].state()),
        )
        for name, times in seconds.items()
    }


def quickest(tasks: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """The shortest wall time of each of several tasks, s, which take turns."""
    seconds = dict.fromkeys(tasks, math.inf)
    for _ in range(rounds):
        for name, task in tasks.items():
            seconds[name] = min(seconds[name], timed(task))
    return seconds


def timed(task: Callable[[], object]) -> float:
    """Wall time of a call, s."""
    began = time.perf_counter()
    task()
    return time.perf_counter() - began


def _in_turn(names: list[str], turn: int) -> Iterator[str]:
    """All names, beginning with another one each turn: who follows whom makes a difference to caches."""
    first = turn % len(names)
    yield from names[first:]
    yield from names[:first]


def _apart(ours: State, theirs: State) -> float:
    distance = np.abs(ours[:3].astype(np.float64) - theirs[:3]).max(axis=0)
    return float(np.mean(distance > 1e-3))

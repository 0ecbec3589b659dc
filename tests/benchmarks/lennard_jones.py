"""A liquid of 100,000 Lennard-Jones atoms in a periodic cube, double precision: nanoseconds a step and atom."""

from __future__ import annotations

import ctypes
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from particlecli.scene.model import Scene
from particlecli.simulate import Simulation
from tests.benchmarks.figures import Figure
from tests.benchmarks.peers.cplusplus import library

COUNT, FEW = 100_000, 8_000
"""Atoms; and those that NumPy gets, whose cost is the same for each."""

DENSITY, CUTOFF, SKIN = 0.8442, 2.5, 0.3
DT = 0.004
MELTING = 500
"""Steps from the lattice to the liquid that is measured."""

STEPS = 20
"""Steps between two looks at the clock."""

ROUNDS = 6
MUST = 200.0

State = NDArray[np.float64]
"""Rows x, y, z, u, v, w of all atoms."""


@dataclass(frozen=True)
class Timed:
    """Nanoseconds a step and atom of the fastest round: on the clock, and of all threads together."""

    wall: float
    cpu: float


class Ours:
    """A `Simulation`, advanced frame by frame."""

    def __init__(self, state: State) -> None:
        count = state.shape[1]
        edge = _edge(count)
        atoms = {"positions": state[:3].T.tolist(), "velocities": state[3:].T.tolist()}
        force = {"type": "lennard_jones", "periodic": {"min": [0, 0, 0], "max": [edge] * 3}}
        scene = {
            "duration": 1e4,
            "fps": 1 / (STEPS * DT),
            "precision": "double",
            "particles": {"atoms": atoms},
            "forces": [force],
            "integrator": {"type": "velocity_verlet", "dt": DT},
        }
        self.system = Simulation(Scene.model_validate(scene), fields={"atoms": frozenset()}).system
        self.system.advance(0.0)

    def advance(self) -> None:
        """Some steps."""
        self.system.advance(self.system.time + STEPS * DT)

    def state(self) -> State:
        """Where the atoms are now."""
        return self.system.get_state().reshape(6, -1)


class CPlusPlus:
    """Verlet's lists in C++."""

    def __init__(self, state: State) -> None:
        self._library, self._count = library("lennard_jones"), state.shape[1]
        self._library.liquid_new.restype = ctypes.c_void_p
        rows = np.ascontiguousarray(state)
        numbers = map(ctypes.c_double, (_edge(self._count), CUTOFF, SKIN, DT))
        self._liquid = ctypes.c_void_p(
            self._library.liquid_new(ctypes.c_void_p(rows.ctypes.data), ctypes.c_int64(self._count), *numbers)
        )

    def advance(self) -> None:
        """Some steps."""
        self._library.liquid_advance(self._liquid, ctypes.c_int64(STEPS))

    def state(self) -> State:
        """Where the atoms are now."""
        rows = np.empty((6, self._count))
        self._library.liquid_state(self._liquid, ctypes.c_void_p(rows.ctypes.data))
        return rows


class NumPy:
    """Pairs from SciPy's tree in each step, the rest in NumPy."""

    def __init__(self, state: State) -> None:
        self._x, self._v = state[:3].T.copy(), state[3:].T.copy()
        self._edge = _edge(len(self._x))
        self._a = self._attract()

    def advance(self) -> None:
        """Some steps."""
        for _ in range(STEPS):
            self._v += 0.5 * DT * self._a
            self._x = (self._x + DT * self._v) % self._edge
            self._a = self._attract()
            self._v += 0.5 * DT * self._a

    def _attract(self) -> State:
        i, j = cKDTree(self._x, boxsize=self._edge).query_pairs(CUTOFF, output_type="ndarray").T
        d = self._x[i] - self._x[j]
        d -= self._edge * np.round(d / self._edge)
        inverse6 = (d**2).sum(axis=1) ** -3
        last = CUTOFF**-8 * (24 - 48 * CUTOFF**-6)
        pull = (inverse6 ** (4 / 3) * (48 * inverse6 - 24) + last)[:, None] * d
        total = [np.bincount(i, pull[:, c], len(self._x)) - np.bincount(j, pull[:, c], len(self._x)) for c in range(3)]
        return np.stack(total, axis=1)


def measure() -> list[Figure]:
    """Ours beside C++ and NumPy, from the same liquid."""
    ours = Ours(_lattice(COUNT))
    for _ in range(MELTING // STEPS):
        ours.advance()
    contestants: dict[str, tuple[Any, int]] = {"ours": (ours, COUNT)}
    start = ours.state()
    if shutil.which("g++"):
        contestants["C++"] = (CPlusPlus(start), COUNT)
    contestants["NumPy and SciPy"] = (NumPy(_lattice(FEW)), FEW)
    best: dict[str, Timed] = {}
    note = f"{_temperature(start):.2f} ε/k; NumPy on fewer atoms"
    for go in range(ROUNDS):
        for name, (contestant, count) in contestants.items():
            timed = _timed(contestant.advance, count)
            best[name] = min(best.get(name, timed), timed, key=lambda each: each.wall)
        if go == 0 and "C++" in contestants:
            note += f"; C++ is {_apart(ours.state(), contestants['C++'][0].state()):.0e} σ apart after {STEPS} steps"
    note += "; of all threads " + ", ".join(f"{name} {each.cpu:.0f}" for name, each in best.items())
    return [
        Figure(
            what=f"Lennard-Jones liquid, {COUNT:,} atoms, double",
            value=best.pop("ours").wall,
            unit="ns",
            better="less",
            must=MUST,
            peers={name: each.wall for name, each in best.items()},
            note=note,
        )
    ]


def _timed(advance: Callable[[], object], count: int) -> Timed:
    wall, cpu = time.perf_counter_ns(), time.process_time_ns()
    advance()
    turns = STEPS * count
    return Timed((time.perf_counter_ns() - wall) / turns, (time.process_time_ns() - cpu) / turns)


def _edge(count: int) -> float:
    return float((count / DENSITY) ** (1 / 3))


def _lattice(count: int) -> State:
    """So many places of a face-centred cubic lattice by chance, and velocities that melt it."""
    rng = np.random.default_rng(1)
    cells = int(np.ceil((count / 4) ** (1 / 3)))
    corners = np.stack(np.meshgrid(*[np.arange(cells)] * 3), -1).reshape(-1, 1, 3)
    sites = (corners + 0.5 * np.array([[0, 0, 0], [0, 1, 1], [1, 0, 1], [1, 1, 0]]) + 0.25).reshape(-1, 3)
    x = rng.permutation(sites)[:count] * _edge(count) / cells
    v = rng.normal(0.0, np.sqrt(1.44), (count, 3))
    return np.concatenate([x.T, (v - v.mean(axis=0)).T])


def _temperature(state: State) -> float:
    return float((state[3:] ** 2).sum() / (3 * state.shape[1]))


def _apart(one: State, other: State) -> float:
    """The largest distance between the same atoms, σ."""
    edge = _edge(one.shape[1])
    d = one[:3] - other[:3]
    return float(np.abs(d - edge * np.round(d / edge)).max())

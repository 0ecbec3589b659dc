"""A dam break of 100,352 particles in two dimensions, a step of one evaluation: particle-steps a second."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from particlecli.scene.model import Scene
from particlecli.simulate import Simulation
from tests.benchmarks.contest import quickest
from tests.benchmarks.figures import Figure
from tests.benchmarks.peers.cplusplus import library

ACROSS = 224
COUNT = 2 * ACROSS**2
WIDTH = 0.05715
SPACING = WIDTH / ACROSS
SMOOTHING = 1.3 * SPACING
SOUND, DENSITY, GRAVITY, ALPHA = 20.0, 1000.0, 9.81, 0.02
DT = 0.25 * SMOOTHING / SOUND

COLLAPSE = 9.0
"""How fast the column gets wider and lower at the beginning, 1/s: as in the middle of its collapse."""

BATCH = 25
"""Steps at a time; so many that lists of neighbours are made anew a few times."""

ROUNDS = 6
LEAST = 5.0
"""Millions of particle-steps a second."""

Numbers = NDArray[np.floating[Any]]


def measure() -> list[Figure]:
    """Beside C++ with sorted cells, and a step by SciPy's tree; all begin alike."""
    ours = Simulation(Scene.model_validate(_scene()), fields={"water": frozenset()}).system
    ours.advance(0.0)
    contestants: dict[str, tuple[Callable[[], object], int]] = {
        "ours": (lambda: ours.advance(ours.time + BATCH * DT), BATCH)
    }
    where = _positions()
    cplusplus = _CPlusPlus(where) if shutil.which("g++") else None
    if cplusplus:
        contestants["C++"] = (lambda: cplusplus.advance(BATCH), BATCH)
    contestants["SciPy"] = (_scipy(where), 1)
    seconds = quickest({name: work for name, (work, _) in contestants.items()}, ROUNDS)
    best = {name: steps * COUNT / seconds[name] / 1e6 for name, (_, steps) in contestants.items()}
    apart = _apart(ours.get_state().reshape(6, -1)[:2], cplusplus) if cplusplus else 0.0
    return [
        Figure(
            what=f"sph dam break, {COUNT:,} particles",
            value=best.pop("ours"),
            unit="M particle-steps/s",
            better="more",
            must=LEAST,
            peers=best,
            note=f"two dimensions, h = 1.3 distances; C++ ends {apart:.2g} distances (rms) from ours",
        )
    ]


def _scene() -> dict[str, Any]:
    layout = {"type": "lattice", "size": [WIDTH, 2 * WIDTH, 0], "center": [WIDTH / 2, WIDTH, 0], "spacing": SPACING}
    velocity = [f"{COLLAPSE}*x", f"-{COLLAPSE}*y", 0]
    return {
        "duration": 1e3 * DT * BATCH,
        "fps": 1 / (BATCH * DT),
        "particles": {"water": {"layout": layout, "velocity": velocity, "mass": DENSITY * SPACING**2}},
        "forces": [
            {"type": "gravity", "acceleration": [0, -GRAVITY, 0]},
            {
                "type": "sph",
                "density": DENSITY,
                "smoothing": SMOOTHING,
                "sound_speed": SOUND,
                "dimensions": 2,
                "viscosity": {"artificial": ALPHA},
            },
        ],
        "planes": [{"normal": [0, 1, 0]}, {"normal": [1, 0, 0]}],
        "integrator": {"type": "symplectic_euler", "dt": DT},
    }


def _positions() -> Numbers:
    places = np.stack(np.meshgrid(np.arange(ACROSS), np.arange(2 * ACROSS)), -1).reshape(-1, 2)
    return ((places + 0.5) * SPACING).astype(np.float32)


class _CPlusPlus:
    """The same fluid in C++, which finds its neighbours anew at every step."""

    def __init__(self, where: Numbers) -> None:
        numbers = [SMOOTHING, DENSITY * SPACING**2, DENSITY, DENSITY * SOUND**2 / 7]
        numbers += [ALPHA * SOUND * SMOOTHING / DENSITY, GRAVITY, DT]
        self._library = library("sph")
        self._library.make.restype = ctypes.c_void_p
        velocities = where * np.array([COLLAPSE, -COLLAPSE], np.float32)
        rows = [np.ascontiguousarray(row) for row in (*where.T, *velocities.T)] + [np.array(numbers, np.float32)]
        x, y, u, v, given = (ctypes.c_void_p(row.ctypes.data) for row in rows)
        self._dam = ctypes.c_void_p(self._library.make(x, y, u, v, ctypes.c_int64(COUNT), given))

    def advance(self, steps: int) -> None:
        """Advance by so many steps."""
        self._library.advance(self._dam, ctypes.c_int64(steps))

    def positions(self) -> Numbers:
        """Where the particles are, shape (2, count), m."""
        rows = np.empty((2, COUNT), np.float32)
        self._library.read(self._dam, *(ctypes.c_void_p(row.ctypes.data) for row in rows))
        return rows


def _apart(ours: Numbers, theirs: _CPlusPlus) -> float:
    return float(np.sqrt(((ours - theirs.positions()) ** 2).sum(axis=0).mean())) / SPACING


def _scipy(where: Numbers) -> Callable[[], object]:
    """Densities and forces of the inner pairs, once: a step of a program written in an afternoon."""
    velocities = np.random.default_rng(0).normal(size=where.shape)
    mass = DENSITY * SPACING**2
    height = 7 / (4 * np.pi * SMOOTHING**2)

    def work() -> Numbers:
        pairs = cKDTree(where).query_pairs(2 * SMOOTHING, output_type="ndarray")
        i, j = pairs.T
        d, v = where[i] - where[j], velocities[i] - velocities[j]
        d2 = (d**2).sum(axis=1)
        q = np.sqrt(d2) / SMOOTHING
        bell = mass * height * (1 - q / 2) ** 4 * (1 + 2 * q)
        density = mass * height + np.bincount(i, bell, COUNT) + np.bincount(j, bell, COUNT)
        stress = DENSITY * SOUND**2 / 7 * (np.maximum(density / DENSITY, 1) ** 7 - 1) / density**2
        push = ALPHA * SOUND * SMOOTHING / DENSITY * np.minimum((d * v).sum(axis=1), 0) / (d2 + 0.01 * SMOOTHING**2)
        factor = mass * 5 * height / SMOOTHING**2 * (1 - q / 2) ** 3 * (stress[i] + stress[j] - push)
        forces = [np.bincount(i, factor * x, COUNT) - np.bincount(j, factor * x, COUNT) for x in d.T]
        total: Numbers = np.stack(forces)
        return total

    return work

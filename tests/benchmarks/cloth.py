"""A cloth of 128 × 128 particles that swings down from two corners, by implicit steps of 1/120 s: steps a second."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, eye_array
from scipy.sparse.linalg import splu

from particlecli.dynamics.coupled.links import Lattice
from particlecli.scene.model import Scene
from particlecli.simulate import Simulation
from tests.benchmarks.contest import quickest
from tests.benchmarks.figures import Figure

ACROSS = 128
MASS = 0.16 / ACROSS**2
SPACING = 1 / (ACROSS - 1)
STIFFNESS = 5e4
GRAVITY = 9.80665
DT = 1 / 120

EXPLICIT_STEPS = 1200
"""Of the same time by symplectic Euler: ω² ≤ 12 k/m, so 2/ω is 8e-6 s and 1042 steps are the fewest that are stable."""

BEGINNING = 12
"""Steps before the clock starts: the cloth has left the plane it began in."""

BATCH, ROUNDS = 20, 2
LEAST = 40.0

Numbers = NDArray[np.floating[Any]]


def measure() -> list[Figure]:
    """Beside the same steps by SciPy, each one linear system, and explicit steps of ours; all from the same state."""
    ours = cloth("implicit_euler", 1)
    for step in range(BEGINNING):
        ours.advance((step + 1) * DT)
    state = ours.get_state()
    explicit = cloth("symplectic_euler", EXPLICIT_STEPS)
    explicit.advance(0.0)
    explicit.set_state(state)

    def batch() -> None:
        for _ in range(BATCH):
            ours.advance(ours.time + DT)

    contestants: dict[str, tuple[Callable[[], object], int]] = {
        "ours": (batch, BATCH),
        "ours, explicit": (lambda: explicit.advance(explicit.time + DT), 1),
        "SciPy": (_SciPy(state.reshape(6, -1)).advance, 1),
    }
    seconds = quickest({name: work for name, (work, _) in contestants.items()}, ROUNDS)
    best = {name: steps / seconds[name] for name, (_, steps) in contestants.items()}
    return [
        Figure(
            what=f"cloth, {ACROSS} × {ACROSS}, implicit steps of 1/120 s",
            value=best.pop("ours"),
            unit="steps/s",
            better="more",
            must=LEAST,
            peers=best,
            note=f"SciPy: splu, one iteration of Newton's method; explicit: {EXPLICIT_STEPS} steps in the same time",
        )
    ]


def cloth(scheme: str, steps: int, precision: str = "single"):  # type: ignore[no-untyped-def]
    """The system of the cloth, by so many steps of a scheme in each 1/120 s."""
    group = {
        "layout": {"type": "grid", "counts": [ACROSS, 1, ACROSS], "spacing": SPACING},
        "mass": MASS,
        "pins": [{"where": "(x < -0.499)*(abs(z) > 0.499)"}],
    }
    scene = {
        "duration": 100,
        "fps": 120,
        "precision": precision,
        "particles": {"cloth": group},
        "forces": [{"type": "gravity"}, {"type": "springs", "stiffness": STIFFNESS}],
        "integrator": {"type": scheme, "dt": DT / steps},
    }
    return Simulation(Scene.model_validate(scene), fields={"cloth": frozenset()}).system


def springs() -> tuple[Numbers, Numbers]:
    """Which particles springs join, shape (n, 2), and their lengths at rest, m."""
    pairs = Lattice((ACROSS, 1, ACROSS)).pairs(("structural", "shear", "bend"))
    own = np.arange(ACROSS**2)
    grid = np.stack([own % ACROSS, own // ACROSS]).T * SPACING
    return pairs, np.linalg.norm(grid[pairs[:, 1]] - grid[pairs[:, 0]], axis=1)


def energy(state: Numbers) -> float:
    """Of motion, height and springs, J; shape of the state (6, particles)."""
    x, v = state[:3].astype(float), state[3:].astype(float)
    pairs, rest = springs()
    stretch = np.linalg.norm(x[:, pairs[:, 1]] - x[:, pairs[:, 0]], axis=0) - rest
    return float(0.5 * STIFFNESS * (stretch**2).sum() + MASS * (GRAVITY * x[1] + 0.5 * (v**2).sum(axis=0)).sum())


class _SciPy:
    """Linearly implicit Euler (Baraff & Witkin, SIGGRAPH 1998) in double precision, its matrix factorized each step."""

    def __init__(self, state: Numbers) -> None:
        self.x, self.v = state[:3].T.astype(float), state[3:].T.astype(float)
        pairs, self.rest = springs()
        self.i, self.j = pairs.T
        # Pinned particles are those that a free fall would have moved.
        self.free = np.repeat(np.abs(self.v).max(axis=1) > 0.0, 3)

    def advance(self) -> None:
        """A step of `DT`."""
        apart = self.x[self.j] - self.x[self.i]
        length = np.linalg.norm(apart, axis=1)
        n = apart / length[:, None]
        pulls = STIFFNESS * (length - self.rest)[:, None] * n
        force = np.zeros_like(self.x)
        np.add.at(force, self.i, pulls)
        np.subtract.at(force, self.j, pulls)
        force[:, 1] -= MASS * GRAVITY
        taut = np.maximum(0.0, 1.0 - self.rest / length)
        blocks = STIFFNESS * ((1.0 - taut)[:, None, None] * n[:, :, None] * n[:, None, :])
        blocks += STIFFNESS * taut[:, None, None] * np.eye(3)
        stiffness = self._assembled(blocks)
        matrix = MASS * eye_array(3 * ACROSS**2) + DT**2 * stiffness
        right = DT * (force.ravel() - DT * (stiffness @ self.v.ravel()))
        change = np.zeros(3 * ACROSS**2)
        change[self.free] = splu(matrix.tocsr()[self.free][:, self.free].tocsc()).solve(right[self.free])
        self.v += change.reshape(-1, 3)
        self.x += DT * self.v

    def _assembled(self, blocks: Numbers):  # type: ignore[no-untyped-def]
        rows, columns = np.meshgrid(np.arange(3), np.arange(3), indexing="ij")
        ends = ((self.i, self.i, 1), (self.j, self.j, 1), (self.i, self.j, -1), (self.j, self.i, -1))
        values = np.concatenate([(sign * blocks).ravel() for _, _, sign in ends])
        at = [(3 * end[:, None, None] + place).ravel() for end, place in ((e[0], rows) for e in ends)]
        to = [(3 * end[:, None, None] + place).ravel() for end, place in ((e[1], columns) for e in ends)]
        size = 3 * ACROSS**2
        return coo_array((values, (np.concatenate(at), np.concatenate(to))), shape=(size, size)).tocsr()

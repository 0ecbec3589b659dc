"""The Pleiades problem, seven bodies for three seconds, to ten digits: milliseconds, beside SciPy's DOP853."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from particlecli.scene.load import load_scene
from particlecli.simulate import Simulation
from tests.benchmarks.contest import quickest
from tests.benchmarks.figures import Figure

PROBLEM = Path(__file__).parents[2] / "scenes" / "reference" / "pleiades.yaml"

SLOWEST, LARGEST = 15.0, 1e-10
"""ms, and the error of positions, m."""

RELATIVE, ABSOLUTE = 1e-12, 1e-13
"""SciPy's tolerances: the largest that bring its error near ours."""

ROUNDS = 15

Doubles = NDArray[np.float64]


def measure() -> list[Figure]:
    """Wall time from t = 0 to the end without compiling, and the error there."""
    scene = load_scene(PROBLEM)
    known = next(each.positions for each in scene.reference if each.positions is not None)
    (bodies,) = scene.particles.values()
    simulation = Simulation(scene, threads=1)
    system = simulation.system

    def ours() -> Doubles:
        system.restart()
        system.advance(scene.duration)
        return system.get_state()

    def scipys() -> Doubles:
        start = np.concatenate([np.array(bodies.positions).T.ravel(), np.array(bodies.velocities).T.ravel()])
        slopes = _slopes(np.array(bodies.masses, float))
        solved = solve_ivp(slopes, (0, scene.duration), start, method="DOP853", rtol=RELATIVE, atol=ABSOLUTE)
        return np.asarray(solved.y[:, -1])

    tasks = {"ours": ours, "SciPy DOP853": scipys}
    errors = {name: float(np.abs(work()[:21].reshape(3, -1).T - np.array(known)).max()) for name, work in tasks.items()}
    best = {name: 1e3 * seconds for name, seconds in quickest(tasks, ROUNDS).items()}
    note = f"errors: ours {errors['ours']:.1e}, SciPy {errors['SciPy DOP853']:.1e} m"
    peers = {"SciPy DOP853": best["SciPy DOP853"]}
    return [
        Figure("Pleiades, dop853 to 1e-10", best["ours"], "ms", "less", must=SLOWEST, peers=peers, note=note),
        Figure("its error", errors["ours"], "m", "less", must=LARGEST, peers={"SciPy DOP853": errors["SciPy DOP853"]}),
    ]


def _slopes(masses: Doubles) -> Callable[[float, Doubles], Doubles]:
    """Newton's attraction of all by all, in NumPy."""

    def slopes(_: float, state: Doubles) -> Doubles:
        x, v = state.reshape(2, 3, -1)
        apart = x[:, None, :] - x[:, :, None]
        squares = (apart**2).sum(axis=0)
        np.fill_diagonal(squares, 1.0)
        pulls = (apart * (masses / (squares * np.sqrt(squares)))).sum(axis=2)
        return np.concatenate([v.ravel(), pulls.ravel()])

    return slopes

"""On what terms schemes are compared."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from particlecli.auto.costs import cost, cost_together
from particlecli.dynamics.integrators.base import AnyScheme
from particlecli.runtime import Precision
from particlecli.scene.integrator import Scheme


@dataclass(frozen=True)
class Terms:
    """On what terms schemes are compared.

    Attributes:
        candidates: schemes that are tried, in this order; the later ones only as far as they may be cheaper than
            those before.
        judge: the scheme of the flight that others are compared with.
        finest: by the precision of the forces the smallest tolerance, m, of the judge.
        cost: of a particle and frame, by the scheme and its steps in a frame.
        most_calls: evaluations in a row that a pilot may take.
    """

    candidates: tuple[Scheme, ...]
    judge: Scheme
    finest: dict[Precision, float]
    cost: Callable[[AnyScheme, float], float]
    most_calls: int


ALONE = Terms(
    candidates=(
        "rk4",
        "midpoint",
        "velocity_verlet",
        "yoshida4",
        "exact",
        "dormand_prince",
        "dop853",
        "implicit_midpoint",
        "radau_iia",
    ),
    judge="dop853",
    finest={"single": 1e-6, "double": 1e-10},
    cost=cost,
    most_calls=30_000,
)
"""For particles of which each moves by itself."""

TOGETHER = Terms(
    candidates=("rk4", "velocity_verlet", "dormand_prince", "implicit_midpoint"),
    judge="dormand_prince",
    finest={"single": 1e-5, "double": 1e-10},
    cost=cost_together,
    most_calls=300_000,
)
"""Where particles act on each other: few, since each scheme is compiled for itself."""

"""On what terms schemes are compared."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from particlecli.auto.costs import cost, cost_together
from particlecli.dynamics.integrators.base import AnyScheme
from particlecli.dynamics.plan import Plan
from particlecli.runtime import Precision
from particlecli.scene.forces import SoftSphere, Springs
from particlecli.scene.integrator import Scheme
from particlecli.scene.model import Scene


@dataclass(frozen=True)
class Terms:
    """On what terms schemes are compared.

    Attributes:
        candidates: schemes that are tried, in this order; the later ones only as far as they may be cheaper than
            those before.
        judge: the scheme of the flight that others are compared with.
        finest: by the precision of the forces the smallest tolerance, m, that the judge begins with.
        deepest: likewise the smallest that it may go on to, as below the rounding of forces would set its steps; not
            below the first where equal steps are to tell how sure it is.
        refinements: how often it may go on, at most.
        cost: of a particle and frame, by the scheme and its steps in a frame.
        most_calls: evaluations in a row that a pilot may take.
        most_of_judge: evaluations that equal steps may take, in parts of those of the judge.
    """

    candidates: tuple[Scheme, ...]
    judge: Scheme
    finest: dict[Precision, float]
    deepest: dict[Precision, float]
    refinements: int
    cost: Callable[[AnyScheme, float], float]
    most_calls: int
    most_of_judge: float


STEADY: Scheme = "symplectic_euler"
"""The scheme that others are compared with where contacts ask for equal steps: the cheapest step, and the only
scheme for grains that remember contacts."""

UNSEEN, FORETOLD = 5, 20
"""Steps in parts of the fewest safe ones where contacts ask for equal ones, and no pilot sees all of these, at least:
nine or so while two grains touch. At most so many where pilots foretell more than they can judge."""


def remembers(scene: Scene) -> bool:
    """Whether grains remember contacts.

    They do so from step to step. So all schemes are of first order there, and steps that are chosen by their error
    become ever shorter.
    """
    return any(isinstance(each, SoftSphere) and each.friction > 0.0 for each in scene.forces)


def lands(plan: Plan) -> bool:
    """Whether bodies of springs meet planes at the ends of steps.

    That makes an error of first order in the step, whatever the scheme, which schemes that choose their steps by their
    own error do not see. Of steps that are too long a corner that meets the ground may turn inside out.
    """
    late = {group.name for group in plan.groups if group.coupled and group.impacts == "end_of_step"}
    return any(isinstance(each.force, Springs) and late & set(each.groups) for each in plan.couplings)


ALONE = Terms(
    candidates=(
        "rk4",
        "midpoint",
        "velocity_verlet",
        "symplectic_euler",
        "yoshida4",
        "exact",
        "dormand_prince",
        "dop853",
        "implicit_midpoint",
        "radau_iia",
    ),
    judge="dop853",
    finest={"single": 1e-6, "double": 1e-10},
    deepest={"single": 1e-7, "double": 1e-14},
    refinements=2,
    cost=cost,
    most_calls=30_000,
    most_of_judge=math.inf,
)
"""For particles of which each moves by itself."""

TOGETHER = Terms(
    candidates=("dormand_prince", "rk4", "rk3", "symplectic_euler", "velocity_verlet", "implicit_midpoint"),
    judge="dormand_prince",
    finest={"single": 1e-5, "double": 1e-10},
    deepest={"single": 1e-5, "double": 1e-14},
    refinements=1,
    cost=cost_together,
    most_calls=300_000,
    most_of_judge=3.0,
)
"""Where particles act on each other: few, since each scheme is compiled for itself."""

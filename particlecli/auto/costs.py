"""What a step of a scheme costs in the engine: a model, so that a choice is the same on every machine."""

from __future__ import annotations

from particlecli.dynamics.integrators.base import AnyScheme, ImplicitRungeKutta

FRAME = 2.0
"""What a frame costs beside its steps: loading, storing, and the births of the next one."""

STEP = 0.3
"""What a step costs beside evaluations: planes, cooling, causes of death."""

LANE_BY_LANE = 8.0
"""Times an evaluation costs more where particles go one by one, not in packs of 16."""

SOLVING = 2.0
"""Times an evaluation costs more where Newton's method needs its Jacobian and solves for it."""

SOLVED_TOGETHER = 30.0
"""Evaluations' worth of an implicit step of particles that act on each other: Newton's and Krylov's iterations."""


def cost_together(scheme: AnyScheme, steps: float) -> float:
    """The same as `cost` for particles that act on each other: each evaluation looks at all pairs, and costs most."""
    if isinstance(scheme, ImplicitRungeKutta):
        return FRAME + steps * SOLVED_TOGETHER * scheme.evaluations
    return FRAME + steps * (scheme.evaluations + STEP)


def cost(scheme: AnyScheme, steps: float) -> float:
    """The cost of a particle and frame, in evaluations of a scheme that works on packs.

    Args:
        scheme: the scheme.
        steps: in a frame; of an adaptive scheme the tries, rejected ones included.
    """
    each = scheme.evaluations + STEP
    if scheme.lane_by_lane:
        each *= LANE_BY_LANE
    if isinstance(scheme, ImplicitRungeKutta):
        each *= SOLVING
    return FRAME + steps * each

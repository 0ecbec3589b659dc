"""Explicit schemes of any kind as tables that one kernel reads."""

import numpy as np

from particlecli.dynamics.integrators.base import AdaptiveRungeKutta, ExplicitRungeKutta, Splitting
from particlecli.dynamics.probe import Doubles

Explicit = ExplicitRungeKutta | AdaptiveRungeKutta | Splitting

EVENLY, ADAPTIVELY, SPLIT = range(3)
"""Kinds of schemes."""

WEIGHT, TIME, ERROR, COARSE, DRIFT = range(5)
"""Columns of a scheme's rows, one for each evaluation; splittings drift before each, their weight is that of a kick."""


def scheme_table(scheme: Explicit) -> tuple[Doubles, Doubles, float, float]:
    """A scheme as data: weights of slopes in stages, its rows, the last drift, and the exponent of its control."""
    if isinstance(scheme, Splitting):
        kicks, drift = [], 0.0
        for move, share in scheme.moves:
            if move == "drift":
                drift += share
            else:
                kicks.append((share, 0.0, 0.0, 0.0, drift))
                drift = 0.0
        return np.zeros((1, 1)), np.array(kicks), drift, 0.0
    stages = len(scheme.b)
    weights, rows = np.zeros((stages, stages)), np.zeros((stages, 5))
    for s, row in enumerate(scheme.a):
        weights[s, : len(row)] = row
    rows[:, WEIGHT], rows[:, TIME] = scheme.b, scheme.c
    if not isinstance(scheme, AdaptiveRungeKutta):
        return weights, rows, 0.0, 0.0
    rows[:, ERROR] = scheme.error
    if scheme.coarse_error is not None:
        rows[:, COARSE] = scheme.coarse_error
    return weights, rows, 0.0, scheme.exponent

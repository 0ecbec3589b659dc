"""Explicit Runge–Kutta tableaux (Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I, II.1)."""

from particlecli.dynamics.integrators.base import ExplicitRungeKutta

EULER = ExplicitRungeKutta(order=1, a=((),), b=(1.0,), c=(0.0,))

MIDPOINT = ExplicitRungeKutta(order=2, a=((), (1 / 2,)), b=(0.0, 1.0), c=(0.0, 1 / 2))

RK3 = ExplicitRungeKutta(
    order=3,
    a=((), (1 / 2,), (-1.0, 2.0)),
    b=(1 / 6, 2 / 3, 1 / 6),
    c=(0.0, 1 / 2, 1.0),
)
"""Kutta's third-order method."""

RK4 = ExplicitRungeKutta(
    order=4,
    a=((), (1 / 2,), (0.0, 1 / 2), (0.0, 0.0, 1.0)),
    b=(1 / 6, 1 / 3, 1 / 3, 1 / 6),
    c=(0.0, 1 / 2, 1 / 2, 1.0),
)
"""The classical fourth-order method."""

"""Implicit Runge–Kutta tableaux (Hairer & Wanner, Solving Ordinary Differential Equations II, IV.3 and IV.5)."""

from math import sqrt

from particlecli.dynamics.integrators.base import ImplicitRungeKutta

IMPLICIT_EULER = ImplicitRungeKutta(order=1, a=((1.0,),), b=(1.0,), c=(1.0,), l_stable=True)

IMPLICIT_MIDPOINT = ImplicitRungeKutta(order=2, a=((1 / 2,),), b=(1.0,), c=(1 / 2,), l_stable=False)
"""The Gauss method of one stage."""

TRAPEZOIDAL = ImplicitRungeKutta(
    order=2, a=((0.0, 0.0), (1 / 2, 1 / 2)), b=(1 / 2, 1 / 2), c=(0.0, 1.0), l_stable=False
)

_D, _W = 1 - sqrt(2) / 2, sqrt(2) / 4

TR_BDF2 = ImplicitRungeKutta(
    order=2, a=((0.0, 0.0, 0.0), (_D, _D, 0.0), (_W, _W, _D)), b=(_W, _W, _D), c=(0.0, 2 * _D, 1.0), l_stable=True
)
"""BDF2 in one step: the trapezoidal rule for (2 − √2)h, then BDF2 for the rest, both with the same weight of the slope
that is solved for (Bank et al. 1985; as a Runge–Kutta method, Hosea & Shampine 1996)."""

_R = sqrt(6)

RADAU_IIA = ImplicitRungeKutta(
    order=5,
    a=(
        ((88 - 7 * _R) / 360, (296 - 169 * _R) / 1800, (-2 + 3 * _R) / 225),
        ((296 + 169 * _R) / 1800, (88 + 7 * _R) / 360, (-2 - 3 * _R) / 225),
        ((16 - _R) / 36, (16 + _R) / 36, 1 / 9),
    ),
    b=((16 - _R) / 36, (16 + _R) / 36, 1 / 9),
    c=((4 - _R) / 10, (4 + _R) / 10, 1.0),
    l_stable=True,
)
"""The Radau method of three stages (Ehle 1969), the last of which is the step itself."""

"""The Dormand–Prince method of order 5 with an embedded one of order 4 (J. Comput. Appl. Math. 6 (1980) 19)."""

from particlecli.dynamics.integrators.base import AdaptiveRungeKutta

DORMAND_PRINCE = AdaptiveRungeKutta(
    order=5,
    a=(
        (),
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
        (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
    ),
    b=(35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84, 0.0),
    c=(0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0),
    error=(71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40),
    coarse_error=None,
    exponent=0.2 - 0.75 * 0.04,
    memory=0.04,
)

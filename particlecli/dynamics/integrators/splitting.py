"""Splitting coefficients (Hairer, Lubich & Wanner, Geometric Numerical Integration, II.5)."""

from itertools import pairwise

from particlecli.dynamics.integrators.base import Move, Splitting

SYMPLECTIC_EULER = Splitting(order=1, moves=(("kick", 1.0), ("drift", 1.0)))

VELOCITY_VERLET = Splitting(order=2, moves=(("kick", 1 / 2), ("drift", 1.0), ("kick", 1 / 2)))


def composition(shares: tuple[float, ...], order: int) -> Splitting:
    """Velocity Verlet steps of the given shares of the step one after the other, their touching kicks joined."""
    kicks = [shares[0] / 2, *((a + b) / 2 for a, b in pairwise(shares)), shares[-1] / 2]
    moves: list[tuple[Move, float]] = [("kick", kicks[0])]
    for share, kick in zip(shares, kicks[1:], strict=True):
        moves += [("drift", share), ("kick", kick)]
    return Splitting(order=order, moves=tuple(moves))


_CUBE_ROOT = 2 ** (1 / 3)
_OUTER = 1 / (2 - _CUBE_ROOT)

YOSHIDA4 = composition((_OUTER, -_CUBE_ROOT * _OUTER, _OUTER), order=4)
"""Yoshida, Phys. Lett. A 150 (1990) 262; Forest & Ruth, Physica D 43 (1990) 105."""

_HALF = (
    0.74167036435061295344822780,
    -0.40910082580003159399730010,
    0.19075471029623837995387626,
    -0.57386247111608226665638773,
    0.29906418130365592384446354,
    0.33462491824529818378495798,
    0.31529309239676659663205666,
)
COMPOSITION8 = composition((*_HALF, 1 - 2 * sum(_HALF), *_HALF[::-1]), order=8)
"""Fifteen stages; Suzuki & Umeno 1993, see Hairer, Lubich & Wanner, Geometric Numerical Integration, V.3.2."""

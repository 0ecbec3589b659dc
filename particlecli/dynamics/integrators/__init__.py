"""Integration schemes: what they are (data, free of Taichi), and the few steppers that carry them out."""

from particlecli.dynamics.integrators.base import AnyScheme, ClosedForm
from particlecli.dynamics.integrators.dop853 import DOP853
from particlecli.dynamics.integrators.dormand_prince import DORMAND_PRINCE
from particlecli.dynamics.integrators.implicit_runge_kutta import (
    IMPLICIT_EULER,
    IMPLICIT_MIDPOINT,
    RADAU_IIA,
    TR_BDF2,
    TRAPEZOIDAL,
)
from particlecli.dynamics.integrators.runge_kutta import EULER, MIDPOINT, RK3, RK4
from particlecli.dynamics.integrators.splitting import COMPOSITION8, SYMPLECTIC_EULER, VELOCITY_VERLET, YOSHIDA4
from particlecli.scene.integrator import Scheme

SCHEMES: dict[Scheme, AnyScheme] = {
    "euler": EULER,
    "midpoint": MIDPOINT,
    "rk3": RK3,
    "rk4": RK4,
    "symplectic_euler": SYMPLECTIC_EULER,
    "velocity_verlet": VELOCITY_VERLET,
    "yoshida4": YOSHIDA4,
    "composition8": COMPOSITION8,
    "dormand_prince": DORMAND_PRINCE,
    "dop853": DOP853,
    "implicit_euler": IMPLICIT_EULER,
    "implicit_midpoint": IMPLICIT_MIDPOINT,
    "trapezoidal": TRAPEZOIDAL,
    "tr_bdf2": TR_BDF2,
    "radau_iia": RADAU_IIA,
    "exact": ClosedForm(),
}

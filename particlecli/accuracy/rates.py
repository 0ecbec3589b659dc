"""How fast motion changes by itself, as far as it can be told from the scene without building anything."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from particlecli.accuracy.states import States, states_at_birth
from particlecli.dynamics.group_plan import GroupPlan, medium
from particlecli.dynamics.plan import Plan
from particlecli.scene.closed_forms import linear
from particlecli.scene.expression import Expression
from particlecli.scene.flows import (
    AbcFlow,
    CurlNoiseFlow,
    DoubleGyreFlow,
    ExpressionFlow,
    FlowTerm,
    TaylorGreenFlow,
    UniformFlow,
    VortexFlow,
)
from particlecli.scene.forces import (
    Drag,
    Force,
    ForceField,
    Gravity,
    OrbitForce,
    PointGravity,
    QuadraticDrag,
    UnaryForce,
    VortexForce,
)

Doubles = NDArray[np.float64]
Flows = Mapping[str, tuple[FlowTerm, ...]]

SAMPLE = 256
"""Particles of a group that are looked at."""

STRONGEST_SHEAR, STRONGEST_WIND = 2.0, 3.0
"""No more is met in turbulence, in a million places, than so many times the root mean square of its |∂u/∂x| and
of its speed; the eigenvalues of ∂u/∂x stay below 1.4 times."""


def is_linear(group: GroupPlan, flows: Flows) -> bool:
    """Whether the equations of motion are linear in position and velocity and the same at all times."""
    if group.carrier is not None:
        return all(map(_is_linear_flow, flows[group.carrier]))
    return all(_is_linear_force(force, flows) for force in group.forces)


def _is_linear_force(force: Force, flows: Flows) -> bool:
    flow = medium(force)
    return linear(force) is not None and (flow is None or all(map(_is_linear_flow, flows[flow])))


def _is_linear_flow(term: FlowTerm) -> bool:
    match term:
        case UniformFlow():
            return True
        case ExpressionFlow():
            return all(slope.constant is not None for slope in _slopes(term.velocity, "xyz"))
        case _:
            return False


def turns(group: GroupPlan) -> bool:
    """Whether forces may turn the velocities of a group, as a magnetic field does."""
    return any(force.depends_on_velocity and not isinstance(force, Drag | QuadraticDrag) for force in group.forces)


def fastest_rate(group: GroupPlan, flows: Flows, states: States) -> float | None:
    """A bound of |α| of the modes of a group at given states, 1/s; None where only the kernels can tell.

    With |∂a/∂x| ≤ K and |∂a/∂v| ≤ D, |α|² ≤ D|α| + K.
    """
    if group.coupled:
        return None
    with np.errstate(all="ignore"):
        if group.carrier is not None:
            rates = _steepness(flows[group.carrier], states)
        else:
            bounds = [_bounds(force, flows, states) for force in group.forces]
            K, D = (sum(bound[i] for bound in bounds) + np.zeros(len(states)) for i in range(2))
            rates = (D + np.sqrt(D**2 + 4.0 * K)) / 2.0
    fastest = float(rates.max(initial=0.0))
    return fastest if math.isfinite(fastest) else None


def fastest_at_birth(plan: Plan) -> float | None:
    """A bound of |α| of the modes of all groups, as their particles are born, 1/s; None as of `fastest_rate`."""
    rates = [fastest_rate(group, plan.flows, states_at_birth(group, SAMPLE)) for group in plan.groups]
    known = [rate for rate in rates if rate is not None]
    return max(known, default=0.0) if len(known) == len(rates) else None


def _bounds(force: UnaryForce, flows: Flows, states: States) -> tuple[Doubles | float, Doubles | float]:
    """Bounds of |∂a/∂x|, 1/s², and |∂a/∂v|, 1/s, that a force adds."""
    terms = flows[name] if (name := medium(force)) else ()
    match force:
        case Gravity():
            return 0.0, 0.0
        case Drag():
            damping = force.coefficient * states.inverse_masses
            return damping * _steepness(terms, states), damping
        case QuadraticDrag():
            wind = _size(states.motion[3:]) + _speed(terms, states)
            damping = 2.0 * force.coefficient * states.inverse_masses * wind
            return damping * _steepness(terms, states), damping
        case PointGravity():
            distance2 = _distance2(force.center, states) + force.softening**2
            return 2.0 * abs(force.strength) * distance2**-1.5, 0.0
        case OrbitForce():
            distance2 = _distance2(force.center, states) + force.core**2
            steepest = max(1.0, force.exponent) * abs(force.strength)
            return steepest * distance2 ** (-(force.exponent + 1.0) / 2.0), 0.0
        case VortexForce():
            offset = states.motion[:3] - np.array(force.center)[:, None]
            distance2 = _size(np.cross(force.axis, offset.T).T) ** 2 + force.core**2
            return (abs(force.swirl) + abs(force.pull)) / distance2, 0.0
        case ForceField():
            parts = [_slopes(_components(force), names) for names in ("xyz", "uvw")]
            K, D = (states.inverse_masses * _norm(part, states) for part in parts)
            return K, D
        case _:
            assert_never(force)


def _components(force: ForceField) -> tuple[Expression, ...]:
    """The force, or the slope of its potential."""
    return force.force or tuple(force.potential.derivative(name) for name in "xyz" if force.potential)


def _slopes(components: Iterable[Expression], names: str) -> list[Expression]:
    return [component.derivative(name) for component in components for name in names]


def _norm(entries: Iterable[Expression], states: States) -> Doubles:
    """Of the matrix with these entries, shape (n,)."""
    squares = sum(np.asarray(entry.evaluate(states.names), dtype=float) ** 2 for entry in entries)
    return np.asarray(np.sqrt(np.broadcast_to(squares, len(states))))


def _size(vectors: Doubles) -> Doubles:
    return np.asarray(np.linalg.norm(vectors, axis=0))


def _distance2(center: tuple[float, float, float], states: States) -> Doubles:
    return _size(states.motion[:3] - np.array(center)[:, None]) ** 2


def _steepness(terms: Iterable[FlowTerm], states: States) -> Doubles:
    """A bound of |∂u/∂x| of a flow, 1/s, shape (n,)."""
    return np.zeros(len(states)) + sum(_term_steepness(term, states) for term in terms)


def _term_steepness(term: FlowTerm, states: States) -> Doubles | float:
    match term:
        case UniformFlow():
            return 0.0
        case VortexFlow():
            return abs(term.circulation) / (2.0 * math.pi * term.core**2)
        case CurlNoiseFlow():
            # Root mean square of a spectrum whose speed falls as |k|^(−1/3), see `CurlNoise`.
            octaves = np.exp2(np.arange(term.octaves))
            mean = math.sqrt((octaves ** (4 / 3)).sum() / (octaves ** (-2 / 3)).sum())
            return STRONGEST_SHEAR * math.tau / term.length * term.speed * mean
        case AbcFlow():
            return term.wave_number * math.hypot(*term.amplitudes)
        case DoubleGyreFlow():
            slope = _gyre_slope(term, states)
            fastest = math.pi * abs(term.amplitude) / term.length
            upwards = 2.0 * term.swing + math.pi * slope**2
            return np.asarray(fastest * np.sqrt(2.0 * (math.pi * slope) ** 2 + upwards**2 + math.pi**2))
        case TaylorGreenFlow():
            return math.tau / term.length * abs(term.speed)
        case ExpressionFlow():
            return _norm(_slopes(term.velocity, "xyz"), states)
        case _:
            assert_never(term)


def _gyre_slope(term: DoubleGyreFlow, states: States) -> Doubles:
    """A bound of |∂f/∂ξ|, see `DoubleGyre`."""
    return np.asarray(1.0 + 2.0 * term.swing * np.abs(states.motion[0] / term.length - 1.0))


def _speed(terms: Iterable[FlowTerm], states: States) -> Doubles:
    """A bound of |u| of a flow, m/s, shape (n,)."""
    return np.zeros(len(states)) + sum(_term_speed(term, states) for term in terms)


def _term_speed(term: FlowTerm, states: States) -> Doubles | float:
    match term:
        case UniformFlow():
            return math.hypot(*term.velocity)
        case VortexFlow():
            return abs(term.circulation) / (2.0 * math.pi * term.core)
        case CurlNoiseFlow():
            return STRONGEST_WIND * term.speed
        case AbcFlow():
            a, b, c = map(abs, term.amplitudes)
            return math.hypot(a + c, b + a, c + b)
        case DoubleGyreFlow():
            return np.asarray(math.pi * abs(term.amplitude) * np.hypot(1.0, _gyre_slope(term, states)))
        case TaylorGreenFlow():
            return abs(term.speed)
        case ExpressionFlow():
            return _norm(term.velocity, states)
        case _:
            assert_never(term)

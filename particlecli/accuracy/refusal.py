"""Refuses to run where a step is so long that the scheme would blow the motion up."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from particlecli.accuracy.linear_analysis import limits_of, linearized, span, usable_schemes
from particlecli.accuracy.rates import SAMPLE, fastest_rate, is_linear, turns
from particlecli.accuracy.states import states_at_birth
from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import AnyScheme, ClosedForm, ImplicitRungeKutta
from particlecli.errors import SimulationError
from particlecli.scene.integrator import Scheme
from particlecli.simulate import Simulation
from particlecli.stability.growth import excess
from particlecli.stability.modes import Modes, describe, modes_of

VISIBLE = 10.0
"""What a scheme may multiply a mode by until the end without being refused."""

RESOLVED = 0.5
"""Step times rate up to which a step resolves a mode: what grows then is an error like any other, except
where the motion is linear and it grows for ever."""


def refuse_unstable(simulation: Simulation) -> None:
    """Make sure that no oscillation or decay grows visibly, the scheme being unstable at the scene's step.

    Particles are judged by the states they are born with; those that act on each other by their springs. Where
    the scene alone tells that all rates are small, nothing is built; else a kernel computes the Jacobian. Motion
    that grows by itself is no fault of the scheme.

    Raises:
        SimulationError: one would; says which, the longest stable step and what to do.
    """
    integrator = simulation.scene.integrator
    if integrator.allow_unstable or integrator.adaptive:
        return
    for group in simulation.plan.groups:
        modes = _exploding_springs(simulation, group) if group.coupled else _exploding(simulation, group)
        if len(modes.rates):
            raise SimulationError(_message(simulation, group, modes))


def _exploding(simulation: Simulation, group: GroupPlan) -> Modes:
    """The modes of a group that the scheme would blow up."""
    flows, step = simulation.plan.flows, simulation.plan.step
    states = states_at_birth(group, SAMPLE)
    linear, steps = is_linear(group, flows), span(simulation.scene, group) / step
    fastest = fastest_rate(group, flows, states)
    if fastest is not None:
        around = Modes.around(fastest, turning=turns(group))
        if not _explode(group.scheme, around, step, steps, linear).any():
            return around.at(slice(0))
    from particlecli.dynamics.probe import Probe  # brings Taichi, which the simulation has started

    probe = Probe(simulation.system.groups[group.name].motion, simulation.scene.precision)
    _, by_position, by_velocity = linearized(probe, states)
    modes = modes_of(by_position, by_velocity if group.newtonian else None).shaped(-1)
    return modes.at(_explode(group.scheme, modes, step, steps, linear))


def _exploding_springs(simulation: Simulation, group: GroupPlan) -> Modes:
    """The modes of its springs that the scheme would blow up."""
    from particlecli.stability.springs import fastest_modes  # brings SciPy, which other scenes do without

    step = simulation.plan.step
    steps = span(simulation.scene, group) / step
    if isinstance(group.scheme, ImplicitRungeKutta):
        return Modes.of_pairs(np.empty(0, complex))
    found = fastest_modes(group, simulation.plan.couplings)
    return found.at(_explode(group.scheme, found, step, steps, linear=False))


def _explode(scheme: AnyScheme, modes: Modes, step: float, steps: float, linear: bool) -> NDArray[np.bool_]:
    """Which modes a scheme blows up in so many steps."""
    factors = excess(scheme, modes, step)
    with np.errstate(divide="ignore"):
        visible = ~(steps * np.log(factors) <= math.log(VISIBLE))
    return modes.counting & visible & (linear | (step * np.abs(modes.rates) > RESOLVED))


def _message(simulation: Simulation, group: GroupPlan, modes: Modes) -> str:
    scene, step = simulation.scene, simulation.plan.step
    factors = excess(group.scheme, modes, step)
    worst = int(np.argmax(factors))
    scheme, mode = scene.integrator.scheme, describe(complex(modes.rates[worst]))
    limits = limits_of(modes, usable_schemes(scene), group.name)
    others = [name for name, limit in limits.items() if _takes_long_steps(name) and limit.step >= step]
    remedies = [
        _shorter(simulation, group, modes, limits[scheme].step),
        *([f"type: {', '.join(others)}: stable at this step"] if others else []),
        "allow_unstable: true, to run it all the same",
    ]
    return "\n".join(
        [
            f"group {group.name}: {scheme} is unstable at steps of {step:.3g} s; {mode} would grow "
            f"{_growth(float(factors[worst]), span(scene, group) / step)}. Give `integrator` one of",
            *(f"  {remedy}" for remedy in remedies),
        ]
    )


def _growth(factor: float, steps: float) -> str:
    """Growth by a factor in every step, in words."""
    if steps * math.log(factor) < math.log(1e6):
        return f"{factor**steps:.3g}-fold"
    return f"{factor:.3g}-fold every step" if factor >= 1.1 else "more than a millionfold"


def _takes_long_steps(scheme: Scheme) -> bool:
    return isinstance(SCHEMES[scheme], ImplicitRungeKutta | ClosedForm)


def _shorter(simulation: Simulation, group: GroupPlan, modes: Modes, limit: float) -> str:
    """The remedy of a shorter step."""
    life = span(simulation.scene, group)
    linear = is_linear(group, simulation.plan.flows)
    low, high = 0.0, simulation.plan.step
    for _ in range(60):
        middle = (low + high) / 2.0
        explodes = _explode(group.scheme, modes, middle, life / middle, linear).any()
        low, high = (low, middle) if explodes else (middle, high)
    reason = f"stable up to {limit:.3g}" if limit > 0.5 * low else "too short for that to be seen"
    return f"dt: {rounded_down(0.9 * low):g} or less: {reason}"


def rounded_down(number: float, digits: int = 2) -> float:
    """A positive number with so many significant digits, and not larger."""
    unit = 10.0 ** (math.floor(math.log10(number)) - digits + 1)
    return math.floor(number / unit) * unit

"""Linearizing a scene's motion at a state: its modes, and the longest stable steps."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from particlecli import runtime
from particlecli.accuracy.analysis import Analysis, GroupAnalysis, Limit
from particlecli.accuracy.rates import is_linear
from particlecli.accuracy.states import States, states_at_birth, states_now
from particlecli.auto.resolve import resolved
from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.plan import make_plan
from particlecli.errors import SceneError, UsageError
from particlecli.scene.checks import check_scene
from particlecli.scene.distributions import support
from particlecli.scene.integrator import Scheme
from particlecli.scene.model import Scene
from particlecli.stability.growth import stability_limit
from particlecli.stability.modes import Doubles, Modes, modes_of

if TYPE_CHECKING:
    from particlecli.dynamics.probe import Probe
    from particlecli.dynamics.system import System

SAMPLE = 512
"""Particles of a group that are looked at."""


def analyze(scene: Scene, *, at: float = 0.0, threads: int | None = None) -> Analysis:
    """Linearize a scene's motion about its state at a time, in double precision.

    Args:
        scene: the scene.
        at: s; the scene is simulated up to there.
        threads: worker threads; none: one a core.

    Raises:
        SceneError, SimulationError: as `Simulation`.
        UsageError: the time is not within the scene's duration.
    """
    if not 0.0 <= at <= scene.duration:
        raise UsageError(f"{at:g} s is not a time of the scene, which lasts from 0 to {scene.duration:g} s")
    check_scene(scene)
    try:
        scene, _ = resolved(scene, threads)
    except SceneError as error:
        raise scene.located(error) from None
    system = _system(scene.model_copy(update={"precision": "double"}), at, threads)
    schemes = usable_schemes(scene)
    alone = [group for group in system.plan.groups if not group.coupled]
    analyses = [_coupled_analysis(system, schemes), *(_group_analysis(system, group, at, schemes) for group in alone)]
    return Analysis(
        scene=scene,
        time=at,
        step=None if scene.integrator.adaptive else system.plan.step,
        groups=tuple(analysis for analysis in analyses if analysis is not None),
    )


def _system(scene: Scene, at: float, threads: int | None) -> System:
    """A scene brought to life and to a time; at t = 0 nothing that advances it is compiled."""
    try:
        plan = make_plan(scene)
    except SceneError as error:
        raise scene.located(error) from None
    runtime.start(scene.precision, threads)
    from particlecli.dynamics.system import System

    system = System(plan)
    if at > 0.0:
        for frame in range(math.ceil(at * scene.fps)):
            system.advance(frame / scene.fps)
        system.advance(at)
    elif system.coupled is not None:
        system.advance(0.0)  # what is born at once
    return system


def _group_analysis(system: System, group: GroupPlan, at: float, schemes: list[Scheme]) -> GroupAnalysis | None:
    from particlecli.dynamics.probe import Probe  # brings Taichi, which runs by now

    states = states_now(system, group, SAMPLE) if at > 0.0 else states_at_birth(group, SAMPLE)
    probe = Probe(system.groups[group.name].motion, "double")
    finite, by_position, by_velocity = linearized(probe, states)
    states = states.at(finite)
    if not len(states):
        return None
    slopes = probe.derivative(states.motion, states.times, states.inverse_masses)[-3:]
    modes = modes_of(by_position, by_velocity if group.newtonian else None).shaped(-1)
    position_size = float(np.linalg.norm(by_position, 2, axis=(1, 2)).max())
    return GroupAnalysis(
        name=group.name,
        newtonian=group.newtonian,
        particles=states.total,
        sampled=len(states),
        linear=is_linear(group, system.plan.flows),
        span=span(system.plan.scene, group),
        acceleration=float(np.median(np.linalg.norm(slopes, axis=0))),
        position_rate=math.sqrt(position_size) if group.newtonian else position_size,
        velocity_rate=float(np.linalg.norm(by_velocity, 2, axis=(1, 2)).max()),
        modes=modes,
        limits=limits_of(modes, schemes, group.name),
    )


def _coupled_analysis(system: System, schemes: list[Scheme]) -> GroupAnalysis | None:
    """Of all particles that act on each other; none where there are none."""
    if system.coupled is None:
        return None
    from particlecli.accuracy.coupled_modes import spectrum  # brings SciPy, which other scenes do without
    from particlecli.accuracy.coupled_motion import CoupledMotion

    motion = CoupledMotion(system)
    if not motion.size:
        return None
    found = spectrum(motion)
    name = ", ".join(motion.names)
    return GroupAnalysis(
        name=name,
        newtonian=True,
        particles=motion.particles,
        sampled=motion.particles,
        linear=False,
        span=max(span(system.plan.scene, group) for group in system.plan.groups if group.coupled),
        acceleration=motion.acceleration,
        position_rate=found.position_rate,
        velocity_rate=found.velocity_rate,
        modes=found.modes,
        limits=limits_of(found.modes, schemes, name),
        coupled=True,
        complete=found.complete,
    )


def linearized(probe: Probe, states: States) -> tuple[NDArray[np.bool_], Doubles, Doubles]:
    """Which states have finite Jacobians, and these: ∂a/∂x and ∂a/∂v (or ∂u/∂x and zero), shape (n, 3, 3)."""
    jacobians = probe.jacobian(states.motion, states.times, states.inverse_masses)
    finite = np.asarray(np.isfinite(jacobians).all(axis=(0, 2, 3)))
    return finite, jacobians[0, finite], jacobians[1, finite]


def limits_of(modes: Modes, schemes: Iterable[Scheme], group: str) -> dict[Scheme, Limit]:
    """The longest step of each scheme at which no mode of a group grows that should not."""
    limits = {}
    for scheme in schemes:
        step, rate = stability_limit(SCHEMES[scheme], modes)
        limits[scheme] = Limit(step, rate, "" if rate is None else group)
    return limits


def span(scene: Scene, group: GroupPlan) -> float:
    """How long a particle of a group moves at most, s."""
    lifetime = scene.groups[group.name].lifetime
    return scene.duration if lifetime is None else min(scene.duration, support(lifetime)[1])


def usable_schemes(scene: Scene) -> list[Scheme]:
    """The schemes with which the scene is valid, in their order."""
    return [scheme for scheme in SCHEMES if _is_usable(scene, scheme)]


def _is_usable(scene: Scene, scheme: Scheme) -> bool:
    integrator = scene.integrator.model_copy(update={"type": scheme, "tolerance": None})
    try:
        check_scene(scene.model_copy(update={"integrator": integrator}))
    except SceneError:
        return False
    return True

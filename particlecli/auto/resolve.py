"""A scene with `integrator.type: auto` made into one with a scheme and a step."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace

from particlecli import runtime
from particlecli.auto.children import children, first_brood
from particlecli.auto.choice import choose
from particlecli.auto.judge import metres
from particlecli.auto.outcome import Choice, Tried, integrator_of
from particlecli.auto.pilot import SAMPLE, Pilot
from particlecli.auto.safe import SafeSteps
from particlecli.auto.terms import ALONE, FORETOLD, STEADY, TOGETHER, UNSEEN, lands, remembers
from particlecli.auto.whole import WholePilot, worth_flying
from particlecli.dynamics.births import EmitterBirths
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.plan import Plan, make_plan
from particlecli.errors import SimulationError
from particlecli.scene.integrator import DEFAULT_STEP, UNCHOSEN
from particlecli.scene.model import Scene

COUPLED = 0.01
"""Share of the error asked for, m, that a step may make where particles act on each other: that of adaptive schemes."""


def resolved(scene: Scene, threads: int | None = None) -> tuple[Scene, Choice | None]:
    """The scene with what `auto` chooses for it, and the choice; any other scene as it is.

    Starts the Taichi runtime in the scene's precision. The scene's parts must fit together.
    """
    if scene.integrator.type != "auto":
        return scene, None
    plan = make_plan(scene)
    runtime.start(scene.precision, threads, plan.structure)
    choice = _chosen(plan)
    return scene.model_copy(update={"integrator": integrator_of(scene, choice.chosen)}), choice


def _chosen(plan: Plan) -> Choice:
    if any(any(group.rides) for group in plan.groups if not group.coupled):
        return _standing(plan.scene)
    if not any(group.coupled for group in plan.groups):
        return choose(plan.scene, _pilots(plan), ALONE, SafeSteps(plan))
    choice, safe = None, SafeSteps(plan)
    if worth_flying(plan):
        with suppress(SimulationError):  # a scheme that cannot go on tells it best in the run itself
            choice = choose(plan.scene, [WholePilot(plan), *_pilots(plan)], TOGETHER, safe)
    return choice if choice and choice.holds else _careful(plan, choice, safe)


def _pilots(plan: Plan) -> list[Pilot]:
    from particlecli.dynamics.flights import Flights  # brings Taichi, which runs by now
    from particlecli.dynamics.system import System

    scene = plan.scene
    apart = [group for group in plan.groups if not group.coupled]
    if not apart:
        return []
    system = System(plan)
    pilots: dict[str, Pilot] = {}
    ranks = {brood.child: place for place, brood in enumerate(plan.broods, 1)}  # parents come before their children
    for group in sorted(apart, key=lambda each: ranks.get(each.name, 0)):
        births, table = group.births, None
        brood = None if births.total else first_brood(plan.broods, pilots, group.name)
        if brood is not None and isinstance(births, EmitterBirths):
            table = children(brood, births, pilots[brood.parent])
        flights = Flights(system.groups[group.name].motion, scene.precision, SAMPLE)
        pilots[group.name] = Pilot(group, flights, 1.0 / scene.fps, scene.duration, table)
    return list(pilots.values())


def _standing(scene: Scene) -> Choice:
    """Where planes move, which pilots take for standing."""
    steps = math.ceil(1.0 / scene.fps / min(DEFAULT_STEP, scene.integrator.dt or math.inf) * (1.0 - 1e-9))
    chosen = Tried(UNCHOSEN, max(1, steps), None, None, 0.0, "")
    return Choice(scene.integrator.goal, chosen, unseen="planes move, and are met at the end of steps")


def _careful(plan: Plan, tried: Choice | None, safe: SafeSteps) -> Choice:
    """Where no pilot tells: an adaptive scheme controls the error of each step, or contacts get many safe steps."""
    scene = plan.scene
    if remembers(scene) or lands(plan):
        chosen = _steady(tried, safe.fewest(SCHEMES[STEADY], scene))
    else:
        tolerance = max(COUPLED * metres(scene), 1e-6 if scene.precision == "single" else 1e-13)
        chosen = Tried("dormand_prince", None, tolerance, None, 0.0, "")
    goal, unseen = scene.integrator.goal, "many particles act on each other"
    if tried is None:
        return Choice(goal, chosen, unseen=unseen)
    best = replace(tried.chosen, why="not accurate enough at any pace that was tried")
    others = tuple(each for each in (best, *tried.rejected) if each.scheme != chosen.scheme)
    return Choice(goal, chosen, others, unseen="no pilot was accurate enough")


def _steady(tried: Choice | None, fewest: int) -> Tried:
    """Many safe steps, and more where pilots foretell more."""
    foretold = [each.steps or 0 for each in (tried.chosen, *tried.rejected) if each.scheme == STEADY] if tried else []
    return Tried(STEADY, min(max([UNSEEN * fewest, *foretold]), FORETOLD * fewest), None, None, 0.0, "")

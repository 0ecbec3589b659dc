"""What a scene needs, worked out before anything is built: state, forces, kernels, steps, memory. Free of Taichi."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import psutil

from particlecli.dynamics.births import EmitterBirths, ParticleBirths
from particlecli.dynamics.group_plan import LANES, GroupPlan, plan_group
from particlecli.dynamics.kin import Brood
from particlecli.dynamics.kinship import Kinship
from particlecli.errors import Problem, SceneError
from particlecli.scene.flows import FlowTerm
from particlecli.scene.forces import Attraction, BodyDrag, CoupledForce, Springs
from particlecli.scene.frames import chain
from particlecli.scene.groups import Emitter, Particles
from particlecli.scene.model import Scene
from particlecli.scene.types import MOST

MOST_SERIAL_PACKS = 32
"""Up to so many packs of particles that act on each other take all steps of a frame in one kernel, on one thread: a
launch would cost more than a stage."""


@dataclass(frozen=True)
class Coupling:
    """A force that particles exert on each other.

    Attributes:
        force: the force.
        number: its place in the scene's forces.
        groups: the groups it acts on and between, those that ever have a particle.
    """

    force: CoupledForce
    number: int
    groups: tuple[str, ...]


@dataclass(frozen=True)
class Plan:
    """What a scene needs.

    Attributes:
        scene: the scene.
        groups: the groups that ever have a particle, in the scene's order.
        flows: the flows that a group needs, by name.
        steps_per_frame: steps that a frame interval is cut into.
        couplings: forces that particles exert on each other.
        broods: what is born of particles, parents before their children.
    """

    scene: Scene
    groups: tuple[GroupPlan, ...]
    flows: dict[str, tuple[FlowTerm, ...]]
    steps_per_frame: int
    couplings: tuple[Coupling, ...]
    broods: tuple[Brood, ...]

    @cached_property
    def memory(self) -> int:
        """Bytes of state of all groups."""
        return sum(group.memory for group in self.groups)

    @property
    def structure(self) -> str:
        """The scene without its numbers and looks: scenes that are alike in this share most kernels."""
        text = self.scene.model_dump_json(exclude={"title", "seed", "camera", "look", "outputs", "reference"})
        return re.sub(r"[-+.\de]*\d", "#", text)

    @property
    def fixed(self) -> list[str]:
        """Groups of the scene that rest in their frames, hence without state."""
        return [name for name, group in self.scene.particles.items() if group.motion == "fixed"]

    @property
    def parentless(self) -> list[str]:
        """Groups with a state of which every particle is born by itself, not of another one."""
        children = {brood.child for brood in self.broods}
        return [group.name for group in self.groups if group.name not in children]

    @property
    def step(self) -> float:
        """Length of a step, s."""
        return 1.0 / self.scene.fps / self.steps_per_frame

    @property
    def unused_flows(self) -> list[str]:
        """Flows of the scene that nothing needs, hence not built."""
        return [name for name in self.scene.flows if name not in self.flows]

    @property
    def empty_groups(self) -> list[str]:
        """Groups of the scene in which nothing is ever born, hence not built."""
        built = {group.name for group in self.groups}.union(self.fixed)
        return [name for name in self.scene.groups if name not in built]


def make_plan(scene: Scene) -> Plan:
    """Work out what a scene needs.

    Raises:
        SceneError: more births than can be numbered, or a state that would not fit into the memory that is free.
        SimulationError: a birth rate that is not finite.
    """
    try:
        return _plan(scene)
    except SceneError as error:
        raise scene.located(error) from None


def _plan(scene: Scene) -> Plan:
    longest = _longest_step(scene)
    steps = 1 if scene.integrator.adaptive else max(1, math.ceil(1.0 / scene.fps / longest * (1.0 - 1e-9)))
    births = {name: _births(scene, name, group) for name, group in scene.groups.items() if group.motion != "fixed"}
    kinship = Kinship(scene, births)
    _check_numbers(kinship)
    planned = (plan_group(scene, name, each, kinship, steps) for name, each in births.items())
    groups = tuple(group for group in planned if group.capacity)
    used = {flow for group in groups for flow in group.flows}
    flows = {name: terms for name, terms in scene.flows.items() if name in used}
    built = {group.name for group in groups}
    couplings = _couplings(scene, groups)
    plan = Plan(
        scene=scene,
        groups=groups if acts_in_one_kernel(groups, couplings) else tuple(map(_at_ends_of_steps, groups)),
        flows=flows,
        steps_per_frame=steps,
        couplings=couplings,
        broods=tuple(brood for brood in kinship.broods if brood.total and built >= {brood.parent, brood.child}),
    )
    _check_memory(plan)
    return plan


def _couplings(scene: Scene, groups: tuple[GroupPlan, ...]) -> tuple[Coupling, ...]:
    numbered = [(number, force) for number, force in enumerate(scene.forces) if isinstance(force, CoupledForce)]
    couplings = (
        Coupling(force, number, tuple(group.name for group in groups if group.newtonian and force.acts_on(group.name)))
        for number, force in numbered
    )
    return tuple(coupling for coupling in couplings if coupling.groups)


def acts_in_one_kernel(groups: Iterable[GroupPlan], couplings: Iterable[Coupling]) -> bool:
    """Whether particles that act on each other are few, by explicit steps and without anything to be sorted before.

    Then they take all steps of a frame in one kernel, which cuts the step of all where one of them meets a plane.
    """
    coupled = {group.name: group for group in groups if group.coupled}
    packs = sum(-(-group.capacity // LANES) for group in coupled.values())
    few = packs <= MOST_SERIAL_PACKS and not any(group.implicit for group in coupled.values())
    return few and all(
        isinstance(each.force, (Springs, BodyDrag))
        or (
            isinstance(each.force, Attraction)
            and not each.force.uses_tree(sum(coupled[name].capacity for name in each.groups))
        )
        for each in couplings
    )


def _at_ends_of_steps(group: GroupPlan) -> GroupPlan:
    return replace(group, contact="end_of_step") if group.coupled else group


def _longest_step(scene: Scene) -> float:
    """The largest step, s, that the scene asks for; impacts are looked for at the end of each."""
    if scene.integrator.type == "exact" and scene.integrator.dt is None and not scene.planes:
        return math.inf
    return scene.integrator.longest_step


def _check_memory(plan: Plan) -> None:
    available = psutil.virtual_memory().available
    if plan.memory <= available:
        return
    largest = max(plan.groups, key=lambda group: group.memory)
    kind = "particles" if largest.name in plan.scene.particles else "emitters"
    raise SceneError(
        [
            Problem(
                f"{kind}.{largest.name}",
                f"the scene needs {plan.memory / 1e9:.1f} GB for its particles and {available / 1e9:.1f} GB are free; "
                f"this group alone holds up to {largest.capacity:,} of {largest.bytes_per_particle} bytes: "
                "fewer particles, a lower rate or shorter lifetimes need less",
            )
        ]
    )


def _births(scene: Scene, name: str, group: Particles | Emitter) -> EmitterBirths | ParticleBirths:
    if isinstance(group, Emitter):
        return EmitterBirths(scene.seed, name, group, scene.duration, chain(scene.frames, group.frame))
    return ParticleBirths(scene, name)


def _check_numbers(kinship: Kinship) -> None:
    excess = kinship.excess()
    if excess:
        name, total = excess
        raise SceneError(
            [
                Problem(
                    f"emitters.{name}",
                    f"up to {total:,} particles could be born here, children included, and a group can number "
                    f"{MOST:,}: bear fewer children, or of fewer parents, or give the parents shorter lifetimes",
                )
            ]
        )

"""What a run costs, counted from what it does and never timed: the same for the same scene on every machine.

In seconds of one core of the machine that the numbers were measured on (EPYC, AVX2; `python -m
tests.benchmarks estimate` shows what comes of them). What is carried again for an estimate is rather priced too high,
and what the run makes besides too low; only their ratio counts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from particlecli.auto.costs import SOLVING
from particlecli.dynamics.group_plan import LANES, GroupPlan
from particlecli.dynamics.integrators.base import ExplicitRungeKutta, Splitting
from particlecli.dynamics.plan import MOST_SERIAL_PACKS, Coupling, Plan
from particlecli.scene.flows import CurlNoiseFlow, FlowTerm, UniformFlow
from particlecli.scene.forces import Attraction, BodyDrag, Springs
from particlecli.scene.look import GroupLook
from particlecli.scene.model import Scene

if TYPE_CHECKING:
    from particlecli.dynamics.system import System

SHARE = 0.04
"""What estimates may cost, in parts of the run: five hundredths, and a fifth of that for what prices do not know."""

START, START_TOGETHER = 1.0, 1.6
"""Starting Python and Taichi and loading kernels, where no particles act on each other, and where some do."""

PICTURES, PIXEL, BODY_PIXEL = 1.2, 2.5e-8, 6.0e-8
"""Loading the renderer; a pixel of a picture and its part of a video, of light alone, and with bodies."""

POINT = 5e-8
"""Writing a particle of a frame into a trajectory or a recording."""

CALL, LAUNCH = 2e-4, 2e-5
"""Advancing a group by a frame, beside evaluations; and one launch of a kernel."""

PACK, TERM, WAVES, OCTAVE = 1e-7, 5e-8, 1.5e-7, 2.5e-7
"""An evaluation for a pack: by itself, of a force or plane, of a flow, and of an octave of turbulence."""

LANE = 0.25
"""The same for one particle, in parts of that for a pack, where particles go one by one."""

TOGETHER, ATTRACTED, JOINED, DRAGGED, CROWDED = 4e-7, 2.2e-8, 2.5e-9, 2e-8, 4.5e-7
"""An evaluation of particles that act on each other: for a pack by itself, and attracted by one particle; for a
particle each spring, the drag along a body, and its neighbours."""

BRANCHES = 1000
"""Particles and cells of a tree that attract a pack, about."""

GRADIENTS = 100
"""Iterations of conjugate gradients in one of Newton's method, about."""

DOUBLE = 2.0
"""Times as much in double precision."""


@dataclass(frozen=True)
class Besides:
    """What a run makes beside simulating.

    Attributes:
        fixed: price of it, s; infinite: estimates may cost what they will.
        point: price of each particle in each frame, s.
    """

    fixed: float = math.inf
    point: float = 0.0


def besides(scene: Scene, size: tuple[int, int] | None, records: int) -> Besides:
    """The price of pictures and records.

    Args:
        scene: what is shown.
        size: of pictures, pixels; none: there are none.
        records: how many trajectories and recordings are written.
    """
    if size is None:
        return Besides(0.0, records * POINT)
    looks = [scene.look.groups.get(name, GroupLook()).as_ for name in scene.groups]
    pixel = PIXEL if {"dots", "glow", "streaks", "hidden"}.issuperset(looks) else BODY_PIXEL
    return Besides(PICTURES + scene.frame_count * size[0] * size[1] * pixel, records * POINT)


def simulated(system: System) -> float:
    """The price of the start and of what a system has done since t = 0."""
    plan = system.plan
    calls = system.time * plan.scene.fps * len(plan.groups) * CALL
    return start(plan) + calls + alone(system) + coupled(system)


def alone(system: System) -> float:
    """The price of what a system has evaluated for particles that do not act on each other."""
    return sum(
        carried(group, system.plan, system.group_evaluations[group.name] / group.capacity, group.capacity)
        for group in system.plan.groups
        if not group.coupled
    )


def coupled(system: System) -> float:
    """The price of what a system has evaluated for particles that act on each other."""
    bound = [group for group in system.plan.groups if group.coupled]
    count = sum(group.capacity for group in bound)
    evaluations = sum(system.group_evaluations[group.name] for group in bound)
    return evaluations / count * together(system.plan) if count else 0.0


def foreseen(plan: Plan) -> float:
    """The least that a run's start and its particles that act on each other can cost."""
    steps = plan.steps_per_frame * (plan.scene.frame_count - 1)
    bound = [group for group in plan.groups if group.coupled]
    evenly = bound and isinstance(bound[0].scheme, ExplicitRungeKutta | Splitting)
    evaluations = steps * bound[0].scheme.evaluations if evenly else 0
    return start(plan) + evaluations * together(plan)


def start(plan: Plan) -> float:
    """The price of a run's start."""
    return START_TOGETHER if plan.couplings else START


def carried(group: GroupPlan, plan: Plan, evaluations: float, count: int) -> float:
    """The price of so many evaluations of each of so many particles of a group, of which each moves by itself."""
    flows = [term for name in group.flows for term in plan.flows[name]]
    pack = PACK + TERM * (len(group.forces) + len(group.planes)) + sum(map(_flow, flows))
    packs: float = math.ceil(count / LANES)
    if not isinstance(group.scheme, ExplicitRungeKutta | Splitting):
        packs = count * LANE * (SOLVING if group.implicit else 1.0)
    return evaluations * packs * pack * _precision(group)


def _flow(term: FlowTerm) -> float:
    if isinstance(term, UniformFlow):
        return 0.0
    return OCTAVE * term.octaves if isinstance(term, CurlNoiseFlow) else WAVES


def together(plan: Plan) -> float:
    """The price of evaluating once what acts on all particles that act on each other; of an implicit scheme, of one
    iteration of Newton's method."""
    groups = {group.name: group for group in plan.groups if group.coupled}
    packs = sum(math.ceil(group.capacity / LANES) for group in groups.values())
    if not packs:
        return 0.0
    some = next(iter(groups.values()))
    forces = sum(_coupling(each, groups) for each in plan.couplings)
    forces += sum(TERM * len(group.forces) * math.ceil(group.capacity / LANES) for group in groups.values())
    once = (packs * TOGETHER + forces) * _precision(some)
    launches = 0.0 if packs <= MOST_SERIAL_PACKS and not some.implicit else LAUNCH
    return (launches + once) * (GRADIENTS if some.implicit else 1)


def _coupling(coupling: Coupling, groups: dict[str, GroupPlan]) -> float:
    force, counts = coupling.force, [groups[name].capacity for name in coupling.groups]
    count = sum(counts)
    match force:
        case Attraction():
            others = min(count, BRANCHES) if force.uses_tree(count) else count
            return ATTRACTED * math.ceil(count / LANES) * others
        case BodyDrag():
            return DRAGGED * count
        case Springs():
            from particlecli.stability.springs import joined_pairs  # brings SciPy, which other scenes do without

            return JOINED * sum(2 * len(joined_pairs(force, groups[name])) for name in coupling.groups)
    return CROWDED * count


def _precision(group: GroupPlan) -> float:
    return DOUBLE if group.real_bytes == 8 else 1.0

"""What one group of a scene needs: state, capacity, forces, flows, planes, causes of death. Free of Taichi."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from particlecli.dynamics.births import Births, EmitterBirths, ParticleBirths
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import AdaptiveRungeKutta, AnyScheme, ImplicitRungeKutta
from particlecli.dynamics.kinship import AGE_ERROR, Kinship
from particlecli.scene.distributions import Distribution, support
from particlecli.scene.forces import CoupledForce, Drag, Force, QuadraticDrag, UnaryForce
from particlecli.scene.frames import Chain, chain
from particlecli.scene.groups import Cooling, Death, Emitter, Particles, Pin
from particlecli.scene.integrator import ContactScheme
from particlecli.scene.model import Scene
from particlecli.scene.planes import Plane
from particlecli.scene.shapes import Layout

MOTION = {"newtonian": ("x", "y", "z", "u", "v", "w"), "first_order": ("x", "y", "z")}
LANES = 16
"""Particles in a pack: one AVX-512 register of f32."""

INTEGER_COMPONENTS = frozenset({"id", "fate", "impacts"})


class Constant(IntEnum):
    """Places in a group's constants: quantities that are the same for all its particles, and the bounds of death."""

    INVERSE_MASS = 0
    LIFETIME = 1
    COOLING_RATE = 2
    COLDEST = 3
    BOX = 4


@dataclass(frozen=True)
class GroupPlan:
    """What one group needs.

    Attributes:
        name: as in the scene.
        births: what its particles are born with, and when.
        newtonian: whether it has velocities and is moved by forces.
        components: the arrays kept for each particle, in order.
        capacity: the most particles alive at once, those born within a frame included.
        scheme, dt: integration scheme and step, s; of an adaptive scheme the frame interval.
        longest_step, tolerance: what limits the steps of an adaptive scheme, s, and m or m/s.
        contact: how planes are met.
        forces: force objects that act on each of its particles alone.
        coupled: whether other forces couple its particles with each other or with those of other groups.
        flows: names of the flows it needs.
        planes, rides: planes it meets, and for each the frames from the world to the one it rides on.
        layout, pins, pin_rides: how its particles are laid out, if they are, which of them forces do not move, and for
            each pin the frames from the world to the one it rides on.
        carrier: the flow that carries it, if it is of first order.
        cooling, dies, lifetime, hottest: how temperature falls; causes of death; how long particles live, s; K.
        bears, bears_at_death: whether children are born of its particles, and whether of dying ones.
        bearing_impacts: of how many impacts of each particle children are born.
        constants: values by place, see `Constant`.
        real_bytes: size of one number.
    """

    name: str
    births: Births
    newtonian: bool
    components: tuple[str, ...]
    capacity: int
    scheme: AnyScheme
    dt: float
    longest_step: float
    tolerance: float
    contact: ContactScheme
    forces: tuple[UnaryForce, ...]
    coupled: bool
    flows: tuple[str, ...]
    planes: tuple[Plane, ...]
    rides: tuple[Chain, ...]
    layout: Layout | None
    pins: tuple[Pin, ...]
    pin_rides: tuple[Chain, ...]
    carrier: str | None
    cooling: Cooling | None
    dies: Death
    lifetime: float | Distribution | None
    bears: bool
    bears_at_death: bool
    bearing_impacts: int
    hottest: float
    constants: tuple[float, ...]
    real_bytes: int

    @property
    def mortal(self) -> bool:
        """Whether particles have a lifetime."""
        return self.lifetime is not None

    @property
    def adaptive(self) -> bool:
        """Whether each particle chooses its own step."""
        return isinstance(self.scheme, AdaptiveRungeKutta)

    @property
    def implicit(self) -> bool:
        """Whether steps are found by solving equations."""
        return isinstance(self.scheme, ImplicitRungeKutta)

    @property
    def impacts(self) -> ContactScheme | None:
        """When impacts on planes happen; none where there are no planes."""
        if not self.planes:
            return None
        return self.contact if self.newtonian else "end_of_step"

    @property
    def motion_components(self) -> tuple[str, ...]:
        """Components the integrator advances."""
        return MOTION["newtonian" if self.newtonian else "first_order"]

    @property
    def solver_components(self) -> tuple[str, ...]:
        """Components of the solver interface's state vector."""
        return self.motion_components + (("temperature",) if "temperature" in self.components else ())

    @property
    def bytes_per_particle(self) -> int:
        """Bytes of state kept for a particle."""
        return sum(4 if name in INTEGER_COMPONENTS else self.real_bytes for name in self.components)

    @property
    def memory(self) -> int:
        """Bytes of state in all, whole packs."""
        return -(-self.capacity // LANES) * LANES * self.bytes_per_particle


def plan_group(
    scene: Scene, name: str, births: EmitterBirths | ParticleBirths, kinship: Kinship, steps: int
) -> GroupPlan:
    """Work out what a group needs.

    Args:
        scene: the scene.
        name: of the group.
        births: what is born in it without parents.
        kinship: what is born of particles.
        steps: how many steps a frame interval is cut into.
    """
    group = scene.groups[name]
    newtonian = group.motion == "newtonian"
    acting = [force for force in scene.forces if newtonian and force.acts_on(name)]
    forces = tuple(force for force in acting if not isinstance(force, CoupledForce))
    coupled = len(forces) < len(acting)
    planes = tuple(plane for plane in scene.planes if plane.on is None or name in plane.on)
    rides = tuple(chain(scene.frames, plane.frame) for plane in planes)
    pins = group.pins if isinstance(group, Particles) else ()
    media = [flow for force in forces if (flow := medium(force)) is not None]
    carrier = None if newtonian else group.flow
    return GroupPlan(
        name=name,
        births=births,
        newtonian=newtonian,
        components=_components(
            group, births, forces, coupled, planes, scene.integrator.adaptive, kinship.related(name)
        ),
        capacity=_capacity(group, births, kinship, name, 1.0 / scene.fps),
        scheme=SCHEMES[scene.integrator.scheme],
        dt=1.0 / scene.fps / steps,
        longest_step=scene.integrator.longest_step,
        tolerance=scene.integrator.local_tolerance,
        contact="end_of_step" if any(rides) else scene.integrator.contact,
        forces=forces,
        coupled=coupled,
        flows=tuple(dict.fromkeys([*media, *([carrier] if carrier else [])])),
        planes=planes,
        rides=rides,
        layout=group.layout if isinstance(group, Particles) else None,
        pins=pins,
        pin_rides=tuple(chain(scene.frames, pin.frame) for pin in pins),
        carrier=carrier,
        cooling=group.cooling,
        dies=group.dies,
        lifetime=group.lifetime,
        bears=bool(group.children),
        bears_at_death=any(rule.on == "death" for rule in group.children),
        bearing_impacts=max((rule.impacts for rule in group.children if rule.on == "impact"), default=0),
        hottest=_hottest(group, births),
        constants=_constants(group),
        real_bytes=8 if scene.precision == "double" else 4,
    )


def medium(force: Force) -> str | None:
    """The flow that a force is relative to, if it names one."""
    return force.flow if isinstance(force, (Drag, QuadraticDrag)) else None


def _capacity(
    group: Particles | Emitter,
    births: ParticleBirths | EmitterBirths,
    kinship: Kinship,
    name: str,
    interval: float,
) -> int:
    if isinstance(births, ParticleBirths):
        return births.total
    longest_life = None if group.lifetime is None else support(group.lifetime)[1]
    own = births.largest_population(longest_life, interval)
    span = math.inf if longest_life is None else longest_life * (1 + AGE_ERROR) + interval
    return min(own + kinship.most_children(name, span), kinship.total(name))


def _hottest(group: Particles | Emitter, births: ParticleBirths | EmitterBirths) -> float:
    """Highest temperature a particle can have, K; worked out only where the step depends on it."""
    if group.cooling is None or group.cooling.radiative is None:
        return 0.0
    return births.hottest or 0.0


def _components(
    group: Particles | Emitter,
    births: ParticleBirths | EmitterBirths,
    forces: tuple[UnaryForce, ...],
    coupled: bool,
    planes: tuple[Plane, ...],
    adaptive: bool,
    related: bool,
) -> tuple[str, ...]:
    can_die = group.lifetime is not None or group.dies != Death() or any(plane.on_hit == "die" for plane in planes)
    can_stick = any(plane.on_hit == "stick" for plane in planes)
    kept = {
        "age": isinstance(group, Emitter) or bool(group.children),
        "lifetime": isinstance(group.lifetime, Distribution),
        "temperature": births.has_temperature,
        "cooling_rate": group.cooling is not None and isinstance(group.cooling.rate, Distribution),
        "inverse_mass": births.has_masses and (coupled or any(force.uses_mass for force in forces)),
        "pace": adaptive and not coupled,
        "id": can_die or related,
        "fate": can_die or can_stick,
        "impacts": any(rule.on == "impact" for rule in group.children),
    }
    return MOTION[group.motion] + tuple(name for name, needed in kept.items() if needed)


def _constants(group: Particles | Emitter) -> tuple[float, ...]:
    rate = group.cooling.rate if group.cooling else None
    box = group.dies.outside
    return (
        0.0 if isinstance(group.mass, Distribution) else 1.0 / group.mass,
        0.0 if group.lifetime is None or isinstance(group.lifetime, Distribution) else group.lifetime,
        0.0 if rate is None or isinstance(rate, Distribution) else rate,
        group.dies.colder_than or 0.0,
        *(box.min if box else (0.0, 0.0, 0.0)),
        *(box.max if box else (0.0, 0.0, 0.0)),
    )

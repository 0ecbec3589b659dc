"""Force objects: what acts on Newtonian particles, and on which groups."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from particlecli.scene.body_forces import BodyDrag, Springs
from particlecli.scene.expression import Expression, Uses
from particlecli.scene.force_model import ForceModel
from particlecli.scene.local_forces import LennardJones, SoftSphere, Sph
from particlecli.scene.types import (
    Direction,
    KeyedError,
    Name,
    NonNegative,
    Positive,
    Real,
    Vector3,
    described,
)

__all__ = [
    "Attraction",
    "BodyDrag",
    "CoupledForce",
    "Drag",
    "Force",
    "ForceField",
    "Gravity",
    "LennardJones",
    "OrbitForce",
    "PlacedForce",
    "PointGravity",
    "QuadraticDrag",
    "SoftSphere",
    "Sph",
    "Springs",
    "UnaryForce",
    "VortexForce",
]

ForceExpression = Annotated[Expression, Uses("x", "y", "z", "u", "v", "w", "t")]
PotentialExpression = Annotated[Expression, Uses("x", "y", "z", "t")]


class PlacedForce(ForceModel):
    """What forces about a point share: the frame they ride on."""

    center: Vector3 = described("the point, m", default=(0.0, 0.0, 0.0))
    frame: Name | None = described("the coordinate frame it rides on; none: the world", default=None)


class Gravity(ForceModel):
    """Uniform gravity: F = m g."""

    type: Literal["gravity"]
    acceleration: Vector3 = described("g, m/s²", default=(0.0, -9.80665, 0.0))


class PointGravity(PlacedForce):
    """Gravity of a point mass: F = −m GM d / (|d|² + softening²)^(3/2), d = x − center; GM < 0 repels."""

    type: Literal["point_gravity"]
    center: Vector3 = described("where the mass is, m", default=(0.0, 0.0, 0.0))
    strength: Real = described("GM, gravitational constant times mass, m³/s²")
    softening: NonNegative = described("Plummer length that keeps close approaches finite, m", default=0.0)
    cutoff: NonNegative = described("no force within this distance, m", default=0.0)


class Drag(ForceModel):
    """Linear (Stokes) drag relative to a flow: F = k (u(x, t) − v)."""

    uses_mass = True

    type: Literal["drag"]
    coefficient: NonNegative = described("k, kg/s")
    flow: Name | None = described("the medium; none: at rest", default=None)

    @property
    def depends_on_velocity(self) -> bool:
        """Always."""
        return True


class QuadraticDrag(ForceModel):
    """Drag of a fast body in a flow: F = k |u − v| (u − v), with k = ½ ρ c_d A."""

    uses_mass = True

    type: Literal["quadratic_drag"]
    coefficient: NonNegative = described("k, kg/m")
    flow: Name | None = described("the medium; none: at rest", default=None)

    @property
    def depends_on_velocity(self) -> bool:
        """Always."""
        return True


class ForceField(ForceModel):
    """Any force, written out: three components as expressions, or the potential it is the gradient of."""

    uses_mass = True

    type: Literal["force_field"]
    force: tuple[ForceExpression, ForceExpression, ForceExpression] | None = described(
        "N; expressions of x, y, z, u, v, w (velocity) and t", default=None
    )
    potential: PotentialExpression | None = described("U, J; an expression of x, y, z, t; F = −∇U", default=None)

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if (self.force is None) == (self.potential is None):
            key = "type" if self.force is None else "potential"
            raise KeyedError(key, "give either `force` (three expressions) or `potential` (one)")
        return self

    @property
    def depends_on_velocity(self) -> bool:
        """Whether an expression names a component of the velocity."""
        return any(component.names & {"u", "v", "w"} for component in self.force or ())


class VortexForce(PlacedForce):
    """Whirl about an axis: a = (swirl axis × ρ − pull ρ) / (|ρ|² + core²), ρ the offset from the axis."""

    type: Literal["vortex"]
    center: Vector3 = described("a point on the axis, m", default=(0.0, 0.0, 0.0))
    axis: Direction = described("direction of the axis; turns right-handed about it", default=(0.0, 1.0, 0.0))
    swirl: Real = described("circumferential acceleration times distance, m²/s²")
    pull: Real = described("acceleration towards the axis times distance, m²/s²", default=0.0)
    core: Positive = described("distance within which it fades, m", default=0.1)


class OrbitForce(PlacedForce):
    """Attraction falling with a power of distance: a = −strength d / (|d|² + core²)^((n+1)/2)."""

    type: Literal["orbit"]
    strength: Real = described("how strong, m^(n+1)/s²; negative repels")
    exponent: NonNegative = described("n: acceleration falls as distance to the power −n", default=1.0)
    core: Positive = described("distance within which it fades, m", default=0.1)


TREE_PAYS = 20_000
"""From so many particles on, `method: auto` takes the tree: about twice what makes it as fast as the direct sum."""


class Attraction(ForceModel):
    """Gravity between every two particles, of one group or two: F = G m m' d / (|d|² + softening²)^(3/2)."""

    type: Literal["attraction"]
    strength: Real = described("G, m³/(kg s²); negative: they repel", default=6.6743e-11)
    softening: NonNegative = described("Plummer length that keeps close approaches finite, m", default=0.0)
    method: Literal["auto", "direct", "tree"] = described(
        "direct: a sum over all pairs; tree: far particles together in the cells of an octree (Barnes–Hut); auto: "
        f"tree from {TREE_PAYS:,} particles on",
        default="auto",
    )
    opening_angle: Positive = described(
        "with the tree: how large a cell may look that is taken as a whole, radians; at 0.5 forces are wrong by 0.03 %",
        default=0.5,
        le=1.0,
    )

    def uses_tree(self, particles: int) -> bool:
        """Whether it takes far particles together, of so many."""
        return self.method == "tree" or (self.method == "auto" and particles >= TREE_PAYS)


UnaryForce = Gravity | PointGravity | Drag | QuadraticDrag | ForceField | VortexForce | OrbitForce
"""Forces that act on each particle alone."""

CoupledForce = Attraction | Springs | BodyDrag | LennardJones | SoftSphere | Sph
"""Forces that particles exert on each other."""

Force = Annotated[UnaryForce | CoupledForce, Field(discriminator="type")]

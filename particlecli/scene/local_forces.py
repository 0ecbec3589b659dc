"""Forces between particles that are near each other: atoms, grains, fluid."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Tag, model_validator

from particlecli.scene.force_model import ForceModel
from particlecli.scene.types import (
    Flag,
    KeyedError,
    NonNegative,
    Positive,
    SceneModel,
    Vector3,
    Whole,
    by_key,
    described,
)


class PeriodicBox(SceneModel):
    """A box whose opposite faces are joined."""

    min: Vector3 = described("corner with the smallest coordinates, m")
    max: Vector3 = described("corner with the largest; where it is the same, there are no faces, m")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if any(low > high for low, high in zip(self.min, self.max, strict=True)):
            raise KeyedError("max", "no coordinate may be below that of min")
        return self

    @property
    def size(self) -> tuple[float, float, float]:
        """Edges, m."""
        x, y, z = (high - low for low, high in zip(self.min, self.max, strict=True))
        return x, y, z


class LennardJones(ForceModel):
    """Atoms that attract each other and repel when close: U = 4ε ((σ/r)¹² − (σ/r)⁶), cut and shifted."""

    uses_mass = True

    type: Literal["lennard_jones"]
    energy: Positive = described("ε, depth of the well, J", default=1.0)
    size: Positive = described("σ, distance at which neither prevails, m", default=1.0)
    cutoff: Positive | None = described("no force beyond, m; none: 2.5 σ", default=None)
    shifted: Literal["potential", "force"] = described(
        "what is zero at the cutoff: the potential alone, or the force as well, by a term in r²; the jump of a force "
        "that is not makes the energy of a liquid drift, by 1e-4 of the kinetic energy in 10,000 steps of "
        "0.004 σ √(m/ε)",
        default="force",
    )
    periodic: PeriodicBox | None = described("box across whose faces atoms act on each other", default=None)

    @property
    def reach(self) -> float:
        """The cutoff, m."""
        return 2.5 * self.size if self.cutoff is None else self.cutoff

    @model_validator(mode="after")
    def _box_holds_cutoff(self) -> Self:
        if self.periodic is not None and any(0 < edge < 2.0 * self.reach for edge in self.periodic.size):
            raise KeyedError("periodic", f"must be at least twice the cutoff of {self.reach:.6g} m wide")
        return self


class SoftSphere(ForceModel):
    """Spheres that push each other away where they overlap, lose energy in collisions and rub: grains."""

    uses_mass = True

    type: Literal["soft_sphere"]
    diameter: Positive = described("D, m")
    stiffness: Positive = described("k, N/m: two that overlap by δ push with k δ")
    damping: NonNegative = described(
        "γ, kg/s: of a collision's speed exp(−π γ/√(4 k m_r − γ²)) is left, m_r = m₁ m₂/(m₁ + m₂)", default=0.0
    )
    friction: NonNegative = described(
        "μ: they stick where they touch, until they rub with this share of what they press with", default=0.0
    )

    @property
    def depends_on_velocity(self) -> bool:
        """Where it damps."""
        return self.damping > 0.0

    @model_validator(mode="after")
    def _friction_needs_damping(self) -> Self:
        if self.friction > 0.0 and self.damping == 0.0:
            raise KeyedError("friction", "needs a `damping`, which it grows with until it slips")
        return self


class Artificial(SceneModel):
    """Viscosity that acts where fluid is compressed, and shrinks with the smoothing length."""

    artificial: NonNegative = described("α of Monaghan's viscosity; 0.01 to 0.1 for water")

    @property
    def value(self) -> float:
        """α."""
        return self.artificial


class Laminar(SceneModel):
    """The viscosity of Navier and Stokes."""

    laminar: NonNegative = described("ν, kinematic viscosity, m²/s")

    @property
    def value(self) -> float:
        """ν, m²/s."""
        return self.laminar


Viscosity = Annotated[
    Annotated[Artificial, Tag("artificial")] | Annotated[Laminar, Tag("laminar")], by_key("artificial", "laminar")
]


class Sph(ForceModel):
    """Weakly compressible fluid, by smoothed particle hydrodynamics; planes that its groups meet are its walls."""

    uses_mass = True

    type: Literal["sph"]
    density: Positive = described("ρ₀, density at rest, kg/m³; in two dimensions kg/m²")
    smoothing: Positive = described(
        "h, smoothing length, m: 1.5 times the distance of neighbours is quick, and forces of pressure are right "
        "within 0.3 % where they stand regularly; 2 times is better for flows that mix them"
    )
    sound_speed: Positive = described("c, m/s: ten times the greatest speed keeps the density within one percent")
    exponent: Whole = described("γ of Tait's equation", default=7, ge=1, le=9)
    dimensions: Literal[2, 3] = described("2: the fluid is a sheet in the x–y plane", default=3)
    kernel: Literal["wendland", "cubic_spline"] = described("smoothing kernel", default="wendland")
    viscosity: Viscosity = described("artificial or laminar", default=Artificial(artificial=0.05))
    density_by: Literal["continuity", "summation"] = described(
        "continuity: the fluid begins at rest density, also at its surface; summation: by what is around",
        default="continuity",
    )
    tension: Flag = described("whether it holds together where it is thinned out: negative pressure", default=False)
    slip: Flag = described("whether it slips along walls; else it sticks to them", default=True)
    periodic: PeriodicBox | None = described(
        "box across whose faces it flows; it takes the place of walls", default=None
    )

    @property
    def depends_on_velocity(self) -> bool:
        """Unless it has no viscosity."""
        return self.viscosity.value > 0.0

    @model_validator(mode="after")
    def _box_holds_kernel(self) -> Self:
        if self.periodic is not None and any(0 < edge < 4.0 * self.smoothing for edge in self.periodic.size):
            raise KeyedError("periodic", f"must be at least four smoothing lengths, {4 * self.smoothing:.6g} m, wide")
        return self

"""Forces that make bodies of particles: springs, and drag that depends on a body's direction."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from particlecli.scene.expression import Expression, Uses
from particlecli.scene.force_model import ForceModel
from particlecli.scene.types import KeyedError, NonNegative, Positive, Whole, described

RestLength = Annotated[Expression, Uses("l", "t", "s", "side")]
Index = Annotated[Whole, Field(ge=0)]
Link = Literal["structural", "shear", "bend"]


class Springs(ForceModel):
    """Damped springs: F = −(stiffness (|l| − r) + damping l′·l/|l|) l/|l|, l from one end to the other."""

    uses_mass = True

    type: Literal["springs"]
    pairs: tuple[tuple[Index, Index], ...] | None = described(
        "the particles that each joins, by their numbers in the group; none: those linked by the group's layout",
        default=None,
        min_length=1,
    )
    links: tuple[Link, ...] | None = described(
        "which links of the layout: structural to the nearest particles, shear across the cells of a grid, bend to the "
        "particles after the nearest; none: all three",
        default=None,
        min_length=1,
    )
    stiffness: NonNegative = described("N/m")
    damping: NonNegative = described("N s/m", default=0.0)
    rest_length: RestLength = described(
        "r, m: an expression of the distance l at first, the time t, and where the spring is in the layout: s from 0 "
        "at one end to 1 at the other, side from -1 to 1 across",
        default=Expression("l"),
    )
    breaks_at: Positive | None = described(
        "strain (|l| − r)/r at which a spring breaks for good; none: never", default=None
    )

    @model_validator(mode="after")
    def _pairs_or_links(self) -> Self:
        if self.pairs is not None and self.links is not None:
            raise KeyedError("links", "are those of a layout; give `pairs` or `links`, not both")
        return self

    @property
    def depends_on_velocity(self) -> bool:
        """Where there is damping."""
        return self.damping > 0


class BodyDrag(ForceModel):
    """Drag that depends on the direction of a body: F = −c v_along − across v_across, c one of along and backward.

    The body's direction at a particle is that from the particle behind it to the one ahead in the layout: a snake
    glides on its scales, and a fish slips through water along itself and pushes against it sideways.
    """

    uses_mass = True

    type: Literal["body_drag"]
    along: NonNegative = described("against motion towards the end of the body at s = 1, kg/s")
    backward: NonNegative | None = described("against motion the other way, kg/s; none: as along", default=None)
    across: NonNegative = described("against motion across the body, kg/s")

    @property
    def depends_on_velocity(self) -> bool:
        """Always."""
        return True

"""Where particles begin: the shapes that emitters have, and the layouts of groups that are there at t = 0."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from particlecli.scene.expression import Expression, Uses
from particlecli.scene.types import (
    MOST,
    Count,
    Direction,
    KeyedError,
    NonNegative,
    Positive,
    Real,
    SceneModel,
    Vector3,
    Whole,
    described,
)


class PointShape(SceneModel):
    """All from one point."""

    type: Literal["point"]
    center: Vector3 = described("middle, m", default=(0.0, 0.0, 0.0))


class LineShape(SceneModel):
    """Evenly from a segment."""

    type: Literal["line"]
    start: Vector3 = described("one end, m")
    end: Vector3 = described("the other end, m")


class DiscShape(SceneModel):
    """Evenly from the area of a disc."""

    type: Literal["disc"]
    center: Vector3 = described("middle, m", default=(0.0, 0.0, 0.0))
    axis: Direction = described("normal of the disc", default=(0.0, 1.0, 0.0))
    radius: Positive = described("radius, m")


class RingShape(SceneModel):
    """Evenly from a circle."""

    type: Literal["ring"]
    center: Vector3 = described("middle, m", default=(0.0, 0.0, 0.0))
    axis: Direction = described("normal of the circle's plane", default=(0.0, 1.0, 0.0))
    radius: Positive = described("radius, m")


class SphereShape(SceneModel):
    """Evenly from the surface of a sphere."""

    type: Literal["sphere"]
    center: Vector3 = described("middle, m", default=(0.0, 0.0, 0.0))
    radius: Positive = described("radius, m")


class BallShape(SceneModel):
    """Evenly from the volume of a ball."""

    type: Literal["ball"]
    center: Vector3 = described("middle, m", default=(0.0, 0.0, 0.0))
    radius: Positive = described("radius, m")


class BoxShape(SceneModel):
    """Evenly from the volume of a box."""

    type: Literal["box"]
    center: Vector3 = described("middle, m", default=(0.0, 0.0, 0.0))
    size: tuple[NonNegative, NonNegative, NonNegative] = described("edge lengths, m")


Shape = Annotated[
    PointShape | LineShape | DiscShape | RingShape | SphereShape | BallShape | BoxShape,
    Field(discriminator="type"),
]


def _alike(value: Any) -> Any:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return (value, value, value) if is_number else value


_Spacings = tuple[Positive, Positive, Positive]
Spacing = Annotated[_Spacings, BeforeValidator(_alike, json_schema_input_type=Positive | _Spacings)]


class GridLayout(SceneModel):
    """A regular lattice; with springs a cloth, or a soft body."""

    type: Literal["grid"]
    center: Vector3 = described("middle, m", default=(0.0, 0.0, 0.0))
    counts: tuple[Count, Count, Count] = described("particles along x, y, z")
    spacing: Spacing = described("distance between neighbours, m; one for all, or one for each of x, y, z")


class LineLayout(SceneModel):
    """Equally spaced along a segment, both ends included; with springs a chain, or a rope."""

    type: Literal["line"]
    start: Vector3 = described("one end, m")
    end: Vector3 = described("the other end, m")
    count: Whole = described("how many", ge=2, le=MOST)


class BallLayout(BallShape):
    """A ball filled at random."""

    count: Count = described("how many")


class BoxLayout(BoxShape):
    """A box filled at random."""

    count: Count = described("how many")


class HairLayout(SceneModel):
    """Straight strands that stand on a part of a ball, their roots spread evenly; with springs hair, or grass."""

    type: Literal["hair"]
    center: Vector3 = described("middle of the ball, m", default=(0.0, 0.0, 0.0))
    radius: NonNegative = described("its radius, m")
    axis: Direction = described("from its middle to the middle of the hair", default=(0.0, 1.0, 0.0))
    spread: Real = described("half angle of the part with hair, degrees", default=90.0, gt=0, le=180)
    strands: Count = described("how many strands")
    count: Whole = described("particles in a strand, the root among them", ge=2, le=MOST)
    length: Positive = described("length of a strand, m")


MOST_PLACES = 20_000_000
"""Of a lattice: they are all looked at."""


class LatticeLayout(SceneModel):
    """A box filled regularly, or the part of it where a condition holds; each particle is in the middle of a cell.

    Cells fill the box from face to face: along each axis there are as many as come nearest to the spacing asked for.
    """

    type: Literal["lattice"]
    center: Vector3 = described("middle, m", default=(0.0, 0.0, 0.0))
    size: tuple[NonNegative, NonNegative, NonNegative] = described("edge lengths, m")
    spacing: Spacing = described(
        "distance between neighbours, m, or nearly so that whole cells fill the box; along an edge of length 0 there "
        "is one particle"
    )
    pattern: Literal["square", "hexagonal"] = described(
        "square: a particle in each cell; hexagonal: rows along x are √3/2 of the spacing apart, every other one "
        "shifted by half of it to and fro",
        default="square",
    )
    where: Annotated[Expression, Uses("x", "y", "z")] | None = described(
        "where there are particles: a comparison of x, y, z, m, or what must be above 0; none: the whole box",
        default=None,
    )

    @model_validator(mode="after")
    def _countable(self) -> Self:
        if (places := math.prod(self.counts)) > MOST_PLACES:
            raise KeyedError("spacing", f"{places:.3g} particles would fit into the box; at most {MOST_PLACES:.3g} may")
        return self

    @property
    def counts(self) -> tuple[int, int, int]:
        """Cells along x, y, z."""
        gaps = self.spacing if isinstance(self.spacing, tuple) else (self.spacing,) * 3
        closer = (1.0, math.sqrt(0.75) if self.pattern == "hexagonal" else 1.0, 1.0)
        x, y, z = (
            max(1, round(min(edge / (gap * share), 1e9)))
            for edge, gap, share in zip(self.size, gaps, closer, strict=True)
        )
        return x, y, z


LinkedLayout = GridLayout | LineLayout | HairLayout
"""Layouts in which every particle has its place, so that springs know which to join."""

CountedLayout = LinkedLayout | BallLayout | BoxLayout
"""Layouts that tell how many particles they have."""

Layout = Annotated[CountedLayout | LatticeLayout, Field(discriminator="type")]

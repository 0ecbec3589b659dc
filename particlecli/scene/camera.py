"""The camera that frames are rendered through."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from particlecli.scene.expression import Expression
from particlecli.scene.frames import TimeExpression
from particlecli.scene.types import (
    Direction,
    KeyedError,
    Name,
    Positive,
    Real,
    SceneModel,
    Whole,
    described,
)

Pixels = Annotated[Whole, Field(ge=16, le=8192)]
Path = tuple[TimeExpression, TimeExpression, TimeExpression]


class DepthOfField(SceneModel):
    """What is nearer or farther than the distance in focus is blurred, as by a lens."""

    aperture: Positive = described("diameter of the lens, m; the wider, the less is sharp")
    focus: Positive | None = described("distance that is sharp, m; none: that of `look_at`", default=None)


class Camera(SceneModel):
    """The camera; where it is and where it looks may be expressions of t, and it may ride on a coordinate frame."""

    position: Path = described(
        "where the camera is, m; numbers or expressions of t",
        default=(Expression(0), Expression(1.5), Expression(6)),
    )
    look_at: Path = described(
        "the point in the middle of the picture, m; numbers or expressions of t",
        default=(Expression(0), Expression(1), Expression(0)),
    )
    up: Direction = described("what is up in the picture", default=(0.0, 1.0, 0.0))
    frame: Name | None = described(
        "the coordinate frame that position, look_at and up are given in; none: the world", default=None
    )
    projection: Literal["perspective", "orthographic"] = described(
        "perspective: what is farther is smaller; orthographic: it is not, and all is as large as at `look_at`",
        default="perspective",
    )
    field_of_view: Real = described("vertical angle of view, degrees", default=40.0, gt=0, lt=170)
    depth_of_field: DepthOfField | None = described("blur out of focus; none: all is sharp", default=None)
    resolution: tuple[Pixels, Pixels] = described("width and height, pixels", default=(1280, 720))

    @property
    def moves(self) -> bool:
        """Whether it may see other things at other times though nothing else moves."""
        return self.frame is not None or any(each.constant is None for each in (*self.position, *self.look_at))

    @model_validator(mode="after")
    def _sees(self) -> Self:
        here, there = ([each.constant for each in point] for point in (self.position, self.look_at))
        view = [b - a for a, b in zip(here, there, strict=True) if a is not None and b is not None]
        if len(view) < 3:
            return self
        if not any(view):
            raise KeyedError("look_at", "is the camera's own position; choose a point to look at")
        cross = (
            view[1] * self.up[2] - view[2] * self.up[1],
            view[2] * self.up[0] - view[0] * self.up[2],
            view[0] * self.up[1] - view[1] * self.up[0],
        )
        if max(map(abs, cross)) <= 1e-9 * max(map(abs, view)):
            raise KeyedError("up", "is the direction the camera looks in; choose another, such as [0, 0, 1]")
        return self

"""Coordinate frames: a tree of poses that emitters, groups, forces and the camera may ride on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from particlecli.scene.expression import Expression, Uses
from particlecli.scene.types import Direction, Name, SceneModel, described

TimeExpression = Annotated[Expression, Uses("t")]

ZERO = Expression(0)
ONE = Expression(1)


class Rotation(SceneModel):
    """A turn about an axis through the frame's origin, right-handed."""

    axis: Direction = described("direction of the axis, in the parent's coordinates")
    angle: TimeExpression = described("rad: a number or an expression of t")


class CoordinateFrame(SceneModel):
    """A pose in the parent frame: x_parent = translate + R(axis, angle) scale x."""

    parent: Name | None = described("the frame it rides on; none: the world", default=None)
    translate: tuple[TimeExpression, TimeExpression, TimeExpression] = described(
        "where its origin is in the parent, m; numbers or expressions of t", default=(ZERO, ZERO, ZERO)
    )
    rotate: Rotation | None = described("how it is turned in the parent; none: not at all", default=None)
    scale: TimeExpression = described("length of its unit in the parent's; a number or an expression of t", default=ONE)


Chain = tuple[CoordinateFrame, ...]
"""The frames from one that rides on the world to the one that something rides on."""


def chain(frames: Mapping[str, CoordinateFrame], name: str | None) -> Chain:
    """The frames that lead from the world to a named one; none for the world itself.

    Raises:
        KeyError: there is no such frame, or no such parent.
        RecursionError: a frame rides on itself.
    """
    links: list[CoordinateFrame] = []
    while name is not None:
        if len(links) > len(frames):
            raise RecursionError(f"frame {name} rides on itself")
        links.append(frames[name])
        name = frames[name].parent
    return tuple(reversed(links))

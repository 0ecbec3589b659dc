"""Planes that particles meet."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Tag

from particlecli.scene.types import (
    Direction,
    Fraction,
    Name,
    NonNegative,
    SceneModel,
    Vector3,
    by_key,
    described,
)


class Coulomb(SceneModel):
    """Dry friction: the tangential impulse is at most the coefficient times the normal one."""

    coulomb: NonNegative = described("coefficient of friction μ")


class Viscous(SceneModel):
    """The classic course's simple model: in contact, a tangential force −k × pressing force × velocity."""

    viscous: NonNegative = described("k, s/m")


def _plain_number_is_coulomb(value: Any) -> Any:
    return {"coulomb": value} if isinstance(value, (int, float)) and not isinstance(value, bool) else value


_AnyFriction = Annotated[
    Annotated[Coulomb, Tag("coulomb")] | Annotated[Viscous, Tag("viscous")], by_key("coulomb", "viscous")
]
Friction = Annotated[
    _AnyFriction, BeforeValidator(_plain_number_is_coulomb, json_schema_input_type=NonNegative | _AnyFriction)
]


class Plane(SceneModel):
    """An infinite plane; particles live on the side its normal points to."""

    point: Vector3 = described("a point on the plane, m", default=(0.0, 0.0, 0.0))
    normal: Direction = described("towards the side where particles live", default=(0.0, 1.0, 0.0))
    restitution: Fraction = described("share of the normal speed that is left after an impact", default=0.5)
    friction: Friction = described(
        "a number or {coulomb: μ} for dry friction, {viscous: k} for the course's",
        default=Coulomb(coulomb=0.0),
    )
    on_hit: Literal["bounce", "stick", "die"] = described("what becomes of a particle that hits", default="bounce")
    frame: Name | None = described(
        "the coordinate frame it rides on; groups that meet such a plane meet all planes at the end of each step; "
        "none: the world",
        default=None,
    )
    on: tuple[Name, ...] | None = described("groups that meet it; none: every group", default=None)

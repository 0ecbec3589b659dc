"""Groups of particles: those there at t = 0 (`particles`) and those born over time (`emitters`)."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Discriminator, Tag, model_validator

from particlecli.scene.distributions import AnyNumber, NonNegativeNumber, PositiveNumber
from particlecli.scene.expression import Expression, Uses
from particlecli.scene.shapes import Layout, PointShape, Shape
from particlecli.scene.types import (
    Count,
    DataFile,
    Direction,
    Flag,
    Fraction,
    KeyedError,
    Name,
    NonNegative,
    Positive,
    Real,
    SceneModel,
    Vector3,
    described,
)

Motion = Literal["newtonian", "first_order", "fixed"]


class Cooling(SceneModel):
    """How temperature falls: dT/dt = −rate (T − ambient) − radiative (T⁴ − ambient⁴)."""

    rate: NonNegativeNumber | None = described("Newton's law of cooling, 1/s", default=None)
    radiative: NonNegative | None = described("radiation, 1/(s K³)", default=None)
    ambient: NonNegative = described("temperature of the surroundings, K", default=293.15)

    @model_validator(mode="after")
    def _some_law(self) -> Self:
        if self.rate is None and self.radiative is None:
            raise ValueError("nothing cools here: give a `rate` (Newton's law), `radiative`, or both")
        return self


class Box(SceneModel):
    """An axis-aligned box."""

    min: Vector3 = described("corner with the smallest coordinates, m")
    max: Vector3 = described("corner with the largest coordinates, m")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if any(low >= high for low, high in zip(self.min, self.max, strict=True)):
            raise KeyedError("min", "each coordinate must be below that of max")
        return self


class Death(SceneModel):
    """When a particle dies, besides at the end of its lifetime and at planes with `on_hit: die`."""

    colder_than: Positive | None = described("a particle colder than this dies, K", default=None)
    outside: Box | None = described("it dies when it leaves this box", default=None)
    non_finite: Flag = described("drop particles whose state is not finite instead of stopping", default=False)


class Children(SceneModel):
    """Particles that are born of each particle of a group, where and when it is."""

    on: Literal["death", "impact", "way"] = described(
        "death: all at once when it dies; impact: when it strikes a plane and lives on; way: one after the other while "
        "it lives"
    )
    emitter: Name = described("the emitter whose shape, direction, speed and so on they are born with")
    count: Count | None = described("how many at each death or impact", default=None)
    impacts: Count = described("how many impacts of each particle bear children, the first ones", default=1)
    rate: Positive | None = described("how many a second along the way of each", default=None)
    inherit_velocity: Fraction = described("share of the parent's velocity they begin with", default=1.0)

    @model_validator(mode="after")
    def _number(self) -> Self:
        if self.on != "way" and (self.count is None or self.rate is not None):
            raise KeyedError("on", f"on {self.on} give a `count`, and no `rate`")
        if self.on != "impact" and self.impacts != 1:
            raise KeyedError("impacts", "goes with `on: impact`")
        if self.on == "way" and (self.rate is None or self.count is not None):
            raise KeyedError("on", "along the way give a `rate`, and no `count`")
        return self


def _several(value: Any) -> Any:
    return (value,) if isinstance(value, (dict, Children)) else value


class Group(SceneModel):
    """What both kinds of groups share."""

    motion: Motion = described(
        "newtonian: position and velocity, moved by forces; first_order: position only, carried by `flow`; "
        "fixed: at rest in its `frame`, for `particles` only",
        default="newtonian",
    )
    flow: Name | None = described("the flow that carries a first_order group", default=None)
    frame: Name | None = described("the coordinate frame in which it is placed or born; none: the world", default=None)
    inherit_velocity: Fraction = described(
        "share of the frame's own velocity, there and then, that newtonian particles begin with", default=1.0
    )
    lifetime: PositiveNumber | None = described("how long a particle lives, s; none: for ever", default=None)
    cooling: Cooling | None = described("how the temperature falls; none: it stays", default=None)
    dies: Death = described("further causes of death", default=Death())
    children: Annotated[
        tuple[Children, ...], BeforeValidator(_several, json_schema_input_type=Children | tuple[Children, ...])
    ] = described("what is born of its particles; one rule or a list", default=())


class Aim(SceneModel):
    """Directions spread evenly over a cap about an axis."""

    axis: Direction = described("middle of the cap", default=(0.0, 1.0, 0.0))
    spread: Real = described("half angle of the cap, degrees; 180: every direction", default=0.0, ge=0, le=180)


class Burst(SceneModel):
    """Many particles at one instant."""

    time: NonNegative = described("when, s")
    count: Count = described("how many")


def _no_negative_rate(rate: Expression) -> Expression:
    if rate.constant is not None and rate.constant < 0:
        raise ValueError("must not be negative")
    return rate


PathExpression = Annotated[Expression, Uses("x", "y", "z", "t")]
Rate = Annotated[Expression, Uses("t"), AfterValidator(_no_negative_rate)]


class Emitter(Group):
    """A group whose particles are born over time."""

    shape: Shape = described("where they are born", default=PointShape(type="point"))
    rate: Rate | None = described(
        "births a second: a number or an expression of t; none are born where it is negative", default=None
    )
    bursts: tuple[Burst, ...] = described("many births at one instant", default=())
    start: NonNegative = described("when the rate sets in, s", default=0.0)
    stop: NonNegative | None = described("when the rate ends, s; none: never", default=None)
    direction: Aim = described("where they are sent", default=Aim())
    speed: NonNegativeNumber = described("speed at birth, m/s", default=0.0)
    mass: PositiveNumber = described("mass of a particle, kg", default=1.0)
    temperature: PositiveNumber | None = described(
        "temperature at birth, K; none: the group has no temperature", default=None
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.stop is not None and self.stop < self.start:
            raise KeyedError("stop", "must not be before start")
        return self


class Pin(SceneModel):
    """Particles of a group that forces do not move: they stay, or go where they are told, and pull on others."""

    where: Annotated[Expression, Uses("x", "y", "z", "s", "side")] = described(
        "which ones: a condition on where they are at first, x, y, z, m, and on their place in the layout, s from 0 at "
        "one end to 1 at the other and side from -1 to 1 across"
    )
    path: tuple[PathExpression, PathExpression, PathExpression] | None = described(
        "where they are, m, as expressions of t and of where they are at first, x, y, z; none: they stay there",
        default=None,
    )
    frame: Name | None = described(
        "the coordinate frame that takes them along from where they are at first; a `path` and its x, y, z are then "
        "coordinates in it; none: the world",
        default=None,
    )


LISTED = {"velocities": "velocity", "masses": "mass", "temperatures": "temperature"}
"""What can be listed particle by particle, and the key that gives one value to all."""


InitialVelocity = Annotated[
    Annotated[AnyNumber, Tag("number")] | Annotated[Annotated[Expression, Uses("x", "y", "z")], Tag("expression")],
    Discriminator(lambda value: "expression" if isinstance(value, (str, Expression)) else "number"),
]
"""A number, a distribution, or an expression of where in its frame the particle is, m."""


class Particles(Group):
    """A group that is there at t = 0: listed, laid out, or read from a file; exactly one of the three."""

    positions: tuple[Vector3, ...] | None = described("where each particle is, m", default=None, min_length=1)
    layout: Layout | None = described("a regular or random arrangement", default=None)
    file: DataFile | None = described(
        ".csv with columns x, y, z [vx, vy, vz, mass, temperature] or .npz with arrays positions "
        "[velocities, masses, temperatures], beside the scene",
        default=None,
    )
    velocities: tuple[Vector3, ...] | None = described("m/s, one for each position", default=None)
    masses: tuple[Positive, ...] | None = described("kg, one for each position", default=None)
    temperatures: tuple[Positive, ...] | None = described("K, one for each position", default=None)
    velocity: tuple[InitialVelocity, InitialVelocity, InitialVelocity] | None = described(
        "m/s, for all of them; expressions are of where each is in its `frame`, x, y, z, m", default=None
    )
    mass: PositiveNumber = described("kg, for all of them", default=1.0)
    temperature: PositiveNumber | None = described("K, for all of them; none: no temperature", default=None)
    pins: tuple[Pin, ...] = described(
        "particles that forces do not move, in a group that springs or other forces between particles act on",
        default=(),
    )

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        given = [key for key in ("positions", "layout", "file") if getattr(self, key) is not None]
        if not given:
            raise ValueError("where are the particles? Give `positions`, `layout` or `file`")
        if len(given) > 1:
            raise KeyedError(given[1], f"give `{given[0]}` or `{given[1]}`, not both")
        return self

    @model_validator(mode="after")
    def _lists_go_with_positions(self) -> Self:
        for plural, singular in LISTED.items():
            values = getattr(self, plural)
            if values is None:
                continue
            if self.positions is None:
                raise KeyedError(plural, f"goes with `positions`; with a layout or file, give `{singular}`")
            if len(values) != len(self.positions):
                raise KeyedError(plural, f"must be as many as positions: {len(self.positions)}, not {len(values)}")
            if getattr(self, singular) != type(self).model_fields[singular].default:
                raise KeyedError(singular, f"give `{plural}` or `{singular}`, not both")
        return self

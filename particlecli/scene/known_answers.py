"""What is known of a result, from a closed form or the literature; `particlecli check` compares it."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, Tag, model_validator

from particlecli.scene.expression import Expression, Uses
from particlecli.scene.types import (
    KeyedError,
    Name,
    NonNegative,
    Positive,
    Real,
    SceneModel,
    Vector3,
    Whole,
    by_key,
    described,
)

NAMES_OF_VELOCITY = frozenset({"u", "v", "w", "speed"})
"""Names in a quantity that only newtonian groups have."""

NAMES_OF_FLUID = frozenset({"density", "pressure"})
"""Names in a quantity that only groups have which an sph fluid is made of."""

Quantity = Annotated[Expression, Uses("x", "y", "z", "u", "v", "w", "t", "speed", "distance", "density", "pressure")]
Statistic = Literal["min", "max", "mean", "rms", "sum"]
Index = Annotated[Whole, Field(ge=0)]


class Absolute(SceneModel):
    """The largest error in the unit of what is compared; a plain number means the same."""

    absolute: Positive = described("m, m/s, J, or the unit of the quantity")

    @property
    def size(self) -> float:
        """The number."""
        return self.absolute


class Relative(SceneModel):
    """The largest error in parts of the known value."""

    relative: Positive = described("0.01 is one per cent")

    @property
    def size(self) -> float:
        """The number."""
        return self.relative


def _plain_number_is_absolute(value: Any) -> Any:
    return {"absolute": value} if isinstance(value, (int, float)) and not isinstance(value, bool) else value


_AnyTolerance = Annotated[
    Annotated[Absolute, Tag("absolute")] | Annotated[Relative, Tag("relative")],
    by_key("absolute", "relative"),
]
Tolerance = Annotated[
    _AnyTolerance, BeforeValidator(_plain_number_is_absolute, json_schema_input_type=Positive | _AnyTolerance)
]


class KnownAnswer(SceneModel):
    """What is known of particles of a group at an instant. Every value that is given is compared."""

    at: NonNegative = described("when, s; between two frames as well")
    group: Name = described("the group whose particles are meant")
    particles: tuple[Index, ...] | None = described(
        "their numbers, from 0 in the order of birth; none: all that are alive then",
        default=None,
        min_length=1,
    )
    where: Quantity | None = described(
        "which of them are meant: a comparison, of the same as in a `quantity`, or what must be above 0; none: all",
        default=None,
    )
    position: Vector3 | None = described("where each of them is, m", default=None)
    positions: tuple[Vector3, ...] | None = described(
        "where they are, m, one after the other", default=None, min_length=1
    )
    velocity: Vector3 | None = described("the velocity of each of them, m/s", default=None)
    velocities: tuple[Vector3, ...] | None = described(
        "their velocities, m/s, one after the other", default=None, min_length=1
    )
    energy: Real | None = described(
        "kinetic and potential energy of them all together, J; potential where a force has one",
        default=None,
    )
    quantity: Quantity | None = described(
        "anything else: an expression of position x, y, z, velocity u, v, w, time t, `speed`, "
        "`distance` from where the particle was at first, and of an sph fluid `density` and `pressure`",
        default=None,
    )
    of_all: Statistic | None = described(
        "compare this of all of them: the smallest or largest, the mean, root mean square or sum; none: each of them",
        default=None,
    )
    value: Real | None = described("what `quantity` is, for each of them or `of_all`", default=None)
    tolerance: Tolerance = described("largest error that passes, a number or {relative: …}")
    source: str = described("how the answer is known: a closed form, a paper", default="")

    @model_validator(mode="after")
    def _something_known(self) -> Self:
        for one, many in (("position", "positions"), ("velocity", "velocities")):
            if getattr(self, one) is not None and getattr(self, many) is not None:
                raise KeyedError(many, f"give `{one}` or `{many}`, not both")
        if (self.quantity is None) != (self.value is None):
            raise KeyedError(
                "value" if self.quantity is None else "quantity",
                "give `quantity` and `value` together: what is measured, and what it is known to be",
            )
        if self.of_all is not None and self.quantity is None:
            raise KeyedError("of_all", "goes with a `quantity`")
        known = (
            self.position,
            self.positions,
            self.velocity,
            self.velocities,
            self.energy,
            self.quantity,
        )
        if all(each is None for each in known):
            raise ValueError("what is known? Give `position`, `velocity`, `energy`, or `quantity` and `value`")
        return self

    @property
    def expressions(self) -> dict[str, Expression]:
        """The expressions it has, by key."""
        given = {"quantity": self.quantity, "where": self.where}
        return {key: each for key, each in given.items() if each is not None}

    @model_validator(mode="after")
    def _nothing_relative_to_zero(self) -> Self:
        if isinstance(self.tolerance, Absolute):
            return self
        vectors = (self.position, *(self.positions or ()), self.velocity, *(self.velocities or ()))
        numbers = (self.energy, self.value)
        if any(vector is not None and not any(vector) for vector in vectors) or 0 in numbers:
            raise KeyedError("tolerance", "is relative to a known value that is zero; give a plain number")
        return self

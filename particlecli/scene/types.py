"""Building blocks of the scene language: the strict base model, vectors, colours, numbers and their units."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import PureWindowsPath
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetCoreSchemaHandler,
    Strict,
)
from pydantic_core import CoreSchema, PydanticKnownError, core_schema


class SceneModel(BaseModel):
    """Base of every part of a scene: immutable, unknown keys refused, numbers finite."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class KeyedError(ValueError):
    """What is wrong between the keys of one model, and which of them to show it at."""

    def __init__(self, key: str, message: str) -> None:
        self.key = key
        super().__init__(message)


def described(description: str, /, **options: Any) -> Any:
    """A pydantic field with its description; the reference and the JSON Schema are made from these."""
    return Field(description=description, **options)


def by_key(*kinds: str, plain: str | None = None) -> Discriminator:
    """Tell the members of a union apart by which key of `kinds` they have; `plain`: what is no mapping."""

    def kind(value: Any) -> str | None:
        if not isinstance(value, (dict, SceneModel)):
            return plain
        keys = value if isinstance(value, dict) else type(value).model_fields
        return next((each for each in kinds if each in keys), None)

    return Discriminator(kind)


def _no_text_or_truth(value: Any) -> Any:
    if isinstance(value, (str, bool)):
        raise PydanticKnownError("int_type")
    return value


def _nonzero(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    if not any(vector):
        raise ValueError("must not be the zero vector: it gives no direction")
    return vector


def _unit(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    largest = max(map(abs, _nonzero(vector)))
    x, y, z = (component / largest for component in vector)
    length = math.hypot(x, y, z)
    if abs(largest * length - 1) <= 1e-15:
        return vector  # Exactly as written, so that a resolved scene reads back equal.
    return x / length, y / length, z / length


Real = Annotated[float, Strict()]
"""A finite number; text and true or false are not taken for numbers."""

Whole = Annotated[int, BeforeValidator(_no_text_or_truth)]
"""A whole number, also when written as 1e6."""

Flag = Annotated[bool, Strict()]
"""true or false."""

Name = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]
Vector3 = tuple[Real, Real, Real]
Direction = Annotated[Vector3, AfterValidator(_unit)]
"""A direction; any length but zero, normalized when read."""

Positive = Annotated[Real, Field(gt=0)]
NonNegative = Annotated[Real, Field(ge=0)]
Fraction = Annotated[Real, Field(ge=0, le=1)]
MOST = 2_000_000_000
"""The largest count: birth indices are 32-bit numbers."""

Count = Annotated[Whole, Field(gt=0, le=MOST)]

HexColor = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]
"""An sRGB colour as #rrggbb."""


@dataclass(frozen=True)
class RelativeFile:
    """An annotation of a path: relative, never leading upwards, with one of these endings (none: any)."""

    endings: tuple[str, ...] = ()

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self.check, handler(source))

    def check(self, path: str) -> str:
        """The path itself.

        Raises:
            ValueError: it is empty, absolute, leads out of its folder, or has another ending.
        """
        if not path.strip():
            raise ValueError("must not be empty")
        if not path.isprintable() or "\\" in path:
            raise ValueError("must be a plain path: folders are separated by /")
        windows = PureWindowsPath(path)
        if windows.drive or windows.root or path.startswith("~"):
            raise ValueError("must be a relative path: a scene stays within its own folders")
        if ".." in windows.parts:
            raise ValueError("must not lead upwards with ..: a scene stays within its own folders")
        if self.endings and windows.suffix.lower() not in self.endings:
            raise ValueError(f"must end in {' or '.join(self.endings)}")
        return path


DataFile = Annotated[str, RelativeFile((".csv", ".npz"))]
"""A table of particles."""

"""Numbers a particle is born with: a plain number or a distribution to draw from."""

from __future__ import annotations

import math
from typing import Annotated, Any, Self

from pydantic import AfterValidator, Tag, model_validator

from particlecli.scene.types import KeyedError, Real, SceneModel, by_key, described

NEGLIGIBLE_SIGMAS = 6.0
"""A normal distribution is taken to stay within so many standard deviations (beyond: 1e-9 of the draws)."""

LARGEST_LOGARITHM = 700.0
"""A float64 and its inverse hold no larger logarithm."""


class Uniform(SceneModel):
    """Every value between two ends equally likely."""

    uniform: tuple[Real, Real] = described("lower and upper end")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.uniform[0] > self.uniform[1]:
            raise KeyedError("uniform", "the lower end must not be above the upper end")
        return self

    @property
    def support(self) -> tuple[float, float]:
        """Smallest and largest value it can take."""
        return self.uniform


class Normal(SceneModel):
    """The Gaussian distribution, cut off where `min` or `max` say so."""

    normal: tuple[Real, Real] = described("mean and standard deviation")
    min: Real | None = described("no value below this", default=None)
    max: Real | None = described("no value above this", default=None)

    @model_validator(mode="after")
    def _sensible(self) -> Self:
        if self.normal[1] < 0:
            raise KeyedError("normal", "the standard deviation must not be negative")
        if self.min is not None and self.max is not None and self.min >= self.max:
            raise KeyedError("min", "must be below max")
        lower, upper = self.support
        if not math.isfinite(upper - lower):
            raise KeyedError("normal", "reaches values that no number can hold")
        if lower > upper:
            raise KeyedError("normal", "min and max leave nothing of it within six standard deviations")
        return self

    @property
    def support(self) -> tuple[float, float]:
        """Smallest and largest value it takes, tails of less than 1e-9 left out."""
        mean, sigma = self.normal
        lower = mean - NEGLIGIBLE_SIGMAS * sigma
        upper = mean + NEGLIGIBLE_SIGMAS * sigma
        return (
            lower if self.min is None else max(lower, self.min),
            upper if self.max is None else min(upper, self.max),
        )


class LogNormal(SceneModel):
    """A quantity whose logarithm is normal: never negative, a long tail upwards."""

    log_normal: tuple[Real, Real] = described("median, and the standard deviation of the natural logarithm")

    @model_validator(mode="after")
    def _positive(self) -> Self:
        if self.log_normal[0] <= 0 or self.log_normal[1] < 0:
            raise KeyedError("log_normal", "the median must be positive and the deviation not negative")
        median, sigma = self.log_normal
        if abs(math.log(median)) + NEGLIGIBLE_SIGMAS * sigma > LARGEST_LOGARITHM:
            raise KeyedError("log_normal", "reaches values that no number can hold; the deviation is one of logarithms")
        return self

    @property
    def support(self) -> tuple[float, float]:
        """Smallest and largest value it takes, tails of less than 1e-9 left out."""
        median, sigma = self.log_normal
        factor = math.exp(NEGLIGIBLE_SIGMAS * sigma)
        return median / factor, median * factor


class Choice(SceneModel):
    """One of a list of values."""

    choice: tuple[Real, ...] = described("the values", min_length=1)
    weights: tuple[Real, ...] | None = described("how likely each is, relative to the others", default=None)

    @model_validator(mode="after")
    def _weighted(self) -> Self:
        if self.weights is not None:
            if len(self.weights) != len(self.choice):
                raise KeyedError("weights", f"{len(self.choice)} values need as many weights, not {len(self.weights)}")
            if min(self.weights) < 0 or sum(self.weights) <= 0:
                raise KeyedError("weights", "must not be negative and not all zero")
        return self

    @property
    def support(self) -> tuple[float, float]:
        """Smallest and largest value it can take."""
        return min(self.choice), max(self.choice)


AnyNumber = Annotated[
    Annotated[Real, Tag("number")]
    | Annotated[Uniform, Tag("uniform")]
    | Annotated[Normal, Tag("normal")]
    | Annotated[LogNormal, Tag("log_normal")]
    | Annotated[Choice, Tag("choice")],
    by_key("uniform", "normal", "log_normal", "choice", plain="number"),
]
"""A number, or a distribution: uniform, normal, log_normal or choice."""


def support(value: float | Uniform | Normal | LogNormal | Choice) -> tuple[float, float]:
    """Smallest and largest value of a number or distribution."""
    return (value, value) if isinstance(value, (int, float)) else value.support


def _gives(value: Any) -> str:
    return "is" if isinstance(value, (int, float)) else "can be"


def _positive(value: Any) -> Any:
    lowest = support(value)[0]
    if lowest <= 0:
        raise ValueError(f"must be positive, and {_gives(value)} {lowest:g}")
    return value


def _non_negative(value: Any) -> Any:
    lowest = support(value)[0]
    if lowest < 0:
        raise ValueError(f"must not be negative, and {_gives(value)} {lowest:g}")
    return value


PositiveNumber = Annotated[AnyNumber, AfterValidator(_positive)]
NonNegativeNumber = Annotated[AnyNumber, AfterValidator(_non_negative)]
Distribution = Uniform | Normal | LogNormal | Choice

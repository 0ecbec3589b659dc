"""Arithmetic expressions in scenes: a whitelisted piece of Python's grammar, never executed as code."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from particlecli.scene import expression_calculus, expression_parser, expression_tree
from particlecli.scene.expression_tree import Node, Number

FUNCTION_NAMES: tuple[str, ...] = tuple(expression_parser.ARGUMENTS)
"""The functions an expression may call."""

NUMPY_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "exp": np.exp,
    "log": np.log,
    "sqrt": np.sqrt,
    "abs": np.abs,
    "min": np.minimum,
    "max": np.maximum,
    "clip": np.clip,
    "floor": np.floor,
    "where": np.where,
    "pow": np.power,
}
"""What the functions mean for floats and NumPy arrays, with `pow` for powers that are not whole or half."""


@dataclass(frozen=True, init=False)
class Expression:
    """An arithmetic expression of named variables, such as `"2*sin(pi*t)"`, or a plain number.

    Two expressions are equal when their sources are. A text that is just a number is kept as that number.

    Raises:
        ValueError: the text is not an expression of the language; the message points at the place.
    """

    source: str
    names: frozenset[str] = field(compare=False, repr=False)
    _tree: Node = field(compare=False, repr=False)

    def __init__(self, source: str | float) -> None:
        if isinstance(source, bool) or not isinstance(source, (str, int, float)):
            raise ValueError("must be a number or an expression in quotes")
        if isinstance(source, float) and not math.isfinite(source):
            raise ValueError("must be a finite number")
        written = " ".join(source.split()) if isinstance(source, str) else repr(source)
        tree = expression_parser.parse(written)
        number = _as_number(written)
        self._set(written if number is None else repr(number), tree)

    def _set(self, source: str, tree: Node) -> None:
        object.__setattr__(self, "source", source)
        object.__setattr__(self, "names", frozenset(expression_tree.variables(tree)))
        object.__setattr__(self, "_tree", tree)

    @property
    def constant(self) -> float | None:
        """Its value where it is a constant, else None."""
        return self._tree.value if isinstance(self._tree, Number) else None

    @property
    def continuous(self) -> bool:
        """Whether it is free of what may jump: comparisons, `where`, `floor` and `%`."""
        return expression_tree.is_continuous(self._tree)

    @property
    def plain(self) -> str | float:
        """What a person would write: a number where the source is one, else the text."""
        number = _as_number(self.source)
        return self.source if number is None else number

    def evaluate(
        self, variables: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]] = NUMPY_FUNCTIONS
    ) -> Any:
        """Its value for floats, NumPy arrays or Taichi packs.

        Walks the tree with Python's operators, so it works on whatever has them. Whole and half powers are
        products and square roots; a comparison is 1 where it holds and 0 elsewhere.

        Args:
            variables: a value for each of `names`.
            functions: what each of `FUNCTION_NAMES`, and `pow`, means for such values.

        Raises:
            ZeroDivisionError: a division by a plain float that is zero; arrays and packs give infinity.
        """
        return expression_tree.evaluate(self._tree, variables, functions)

    def derivative(self, name: str) -> Expression:
        """The derivative with respect to a variable, right wherever it exists."""
        result = Expression.__new__(Expression)
        tree = expression_calculus.derivative(self._tree, name)
        result._set(expression_tree.text(tree), tree)
        return result

    @classmethod
    def __get_pydantic_core_schema__(cls, _source: Any, _handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(
            lambda value: value if isinstance(value, Expression) else cls(value),
            serialization=core_schema.plain_serializer_function_ser_schema(lambda value: value.plain),
        )

    @classmethod
    def __get_pydantic_json_schema__(cls, _schema: CoreSchema, _handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"type": ["number", "string"]}


@dataclass(frozen=True)
class Uses:
    """An annotation of an `Expression` in a model: the names it may use, and no others."""

    names: tuple[str, ...]

    def __init__(self, *names: str) -> None:
        object.__setattr__(self, "names", names)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self.check, handler(source))

    def check(self, expression: Expression) -> Expression:
        """The expression itself.

        Raises:
            ValueError: it uses another name; the message points at it and names the nearest.
        """
        for name in sorted(expression.names.difference(self.names)):
            found = re.search(rf"\b{re.escape(name)}\b", expression.source)
            nearest = difflib.get_close_matches(name.lower(), [*FUNCTION_NAMES, "pi"], 1)
            hint = f"did you mean `{nearest[0]}`? " if nearest else ""
            message = f"unknown name `{name}`; {hint}known here: {', '.join(self.names)} and pi"
            raise expression_parser.show(expression.source, found.start() if found else 0, message)
        return expression


def _as_number(text: str) -> int | float | None:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return None

"""Formulas as trees: the nodes, their value for any kind of number, constant folding, and back to text."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

ARITHMETIC: Mapping[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "%": operator.mod,
}
COMPARISONS: Mapping[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}
LARGEST_MULTIPLIED_POWER = 64
"""Integer and half-integer powers up to this are products and square roots; beyond, the function `pow`."""


@dataclass(frozen=True, slots=True)
class Number:
    """A constant."""

    value: float


@dataclass(frozen=True, slots=True)
class Variable:
    """A name that has a value when the formula is evaluated."""

    name: str


@dataclass(frozen=True, slots=True)
class Operation:
    """Two operands joined by one of `+ - * / % **` or a comparison."""

    symbol: str
    left: Node
    right: Node


@dataclass(frozen=True, slots=True)
class Negation:
    """Minus the operand."""

    operand: Node


@dataclass(frozen=True, slots=True)
class Call:
    """A function of one to three arguments; `min` and `max` have two."""

    function: str
    arguments: tuple[Node, ...]


Node = Number | Variable | Operation | Negation | Call
ZERO, ONE = Number(0.0), Number(1.0)


def _float_where(condition: bool, chosen: float, otherwise: float) -> float:
    return chosen if condition else otherwise


FLOAT_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "exp": math.exp,
    "log": math.log,
    "sqrt": math.sqrt,
    "abs": abs,
    "min": min,
    "max": max,
    "clip": lambda value, low, high: min(max(value, low), high),
    "floor": lambda value: float(math.floor(value)),
    "where": _float_where,
    "pow": math.pow,
}
"""The functions for plain floats; unlike NumPy's, they raise where a result is not a finite number."""


def parts(node: Node) -> tuple[Node, ...]:
    """The nodes directly below a node."""
    match node:
        case Operation(_, left, right):
            return left, right
        case Negation(operand):
            return (operand,)
        case Call(_, arguments):
            return arguments
        case _:
            return ()


def variables(node: Node) -> Iterator[str]:
    """The names in a tree, each as often as it stands there."""
    if isinstance(node, Variable):
        yield node.name
    for part in parts(node):
        yield from variables(part)


def is_continuous(node: Node) -> bool:
    """Whether a tree is free of what may jump: comparisons, `where`, `floor` and `%`."""
    match node:
        case Operation(symbol) if symbol in COMPARISONS or symbol == "%":
            return False
        case Call("where" | "floor"):
            return False
    return all(map(is_continuous, parts(node)))


def evaluate(root: Node, values: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]]) -> Any:
    """The value of a tree; equal parts that are shared in memory are computed once."""
    known: dict[int, Any] = {}

    def value(node: Node) -> Any:
        if id(node) not in known:
            known[id(node)] = compute(node)
        return known[id(node)]

    def compute(node: Node) -> Any:
        match node:
            case Number(number):
                return number
            case Variable(name):
                return values[name]
            case Negation(operand):
                return -value(operand)
            case Operation("**", base, Number(exponent)):
                return _constant_power(value(base), exponent, functions)
            case Operation("**", base, exponent):
                return functions["pow"](value(base), value(exponent))
            case Operation(symbol, left, right) if symbol in ARITHMETIC:
                return ARITHMETIC[symbol](value(left), value(right))
            case Operation():
                return functions["where"](mask(node), 1.0, 0.0)
            case Call("where", (condition, chosen, otherwise)):
                return functions["where"](mask(condition), value(chosen), value(otherwise))
            case Call(function, arguments):
                return functions[function](*map(value, arguments))

    def mask(node: Node) -> Any:
        if isinstance(node, Operation) and node.symbol in COMPARISONS:
            return COMPARISONS[node.symbol](value(node.left), value(node.right))
        return value(node) != 0.0

    return value(root)


def _constant_power(base: Any, exponent: float, functions: Mapping[str, Callable[..., Any]]) -> Any:
    size = abs(exponent)
    if size > LARGEST_MULTIPLIED_POWER or not (2 * size).is_integer():
        return functions["pow"](base, exponent)
    result = None if size.is_integer() else functions["sqrt"](base)
    square, remaining = base, int(size)
    while remaining:
        if remaining & 1:
            result = square if result is None else result * square
        remaining >>= 1
        if remaining:
            square = square * square
    if result is None:
        return 1.0
    return 1.0 / result if exponent < 0 else result


def fold(node: Node) -> Node:
    """The node, or its value where all directly below it are constants.

    Raises:
        ArithmeticError, ValueError: the value is not a finite number.
    """
    below = parts(node)
    if not below or not all(isinstance(part, Number) for part in below):
        return node
    value = float(evaluate(node, {}, FLOAT_FUNCTIONS))
    if not math.isfinite(value):
        raise OverflowError("the value is not a finite number")
    return Number(value)


_PRECEDENCE = {**dict.fromkeys(COMPARISONS, 1), "+": 2, "-": 2, "*": 3, "/": 3, "%": 3, "**": 5}
_NEGATION = 4


def text(node: Node, outer: int = 0) -> str:
    """The tree written as a formula that parses to the same tree."""
    match node:
        case Number(value):
            written = str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
            return f"({written})" if value < 0 and outer > 0 else written
        case Variable(name):
            return name
        case Negation(operand):
            written, own = f"-{text(operand, _NEGATION)}", _NEGATION
        case Call(function, arguments):
            return f"{function}({', '.join(map(text, arguments))})"
        case Operation(symbol, left, right):
            own = _PRECEDENCE[symbol]
            # ** groups to the right, arithmetic to the left, and comparisons must not become chains.
            tight_left = own + 1 if symbol == "**" or own == 1 else own
            written = f"{text(left, tight_left)} {symbol} {text(right, own + (symbol != '**'))}"
    return f"({written})" if own < outer else written

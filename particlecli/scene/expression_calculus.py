"""Derivatives of formulas by the rules of the differential calculus, lightly simplified."""

from __future__ import annotations

import math

from particlecli.scene.expression_tree import (
    ONE,
    ZERO,
    Call,
    Negation,
    Node,
    Number,
    Operation,
    Variable,
    fold,
)

TWO = Number(2.0)


def derivative(node: Node, name: str) -> Node:
    """The derivative with respect to a variable, right wherever it exists.

    At the kinks of `abs`, `min`, `max` and `clip` it is the slope of one side; comparisons and `floor`
    count as constant, and `where` as whichever branch is taken.
    """
    match node:
        case Number():
            return ZERO
        case Variable(other):
            return ONE if other == name else ZERO
        case Negation(operand):
            return negative(derivative(operand, name))
        case Operation(symbol, left, right):
            return _of_operation(symbol, left, right, derivative(left, name), derivative(right, name))
        case Call(function, arguments):
            return _of_call(function, arguments, tuple(derivative(part, name) for part in arguments))


def _of_operation(symbol: str, left: Node, right: Node, dleft: Node, dright: Node) -> Node:
    match symbol:
        case "+":
            return plus(dleft, dright)
        case "-":
            return minus(dleft, dright)
        case "*":
            return plus(times(dleft, right), times(left, dright))
        case "/":
            if dright == ZERO:
                return over(dleft, right)
            return over(minus(times(dleft, right), times(left, dright)), power(right, TWO))
        case "%":
            return minus(dleft, times(dright, Call("floor", (over(left, right),))))
        case "**":
            return _of_power(left, right, dleft, dright)
        case _:
            return ZERO


def _of_power(base: Node, exponent: Node, dbase: Node, dexponent: Node) -> Node:
    by_base = times(times(exponent, power(base, minus(exponent, ONE))), dbase)
    if dexponent == ZERO:
        return by_base
    by_exponent = times(times(power(base, exponent), _folded(Call("log", (base,)))), dexponent)
    return plus(by_base, by_exponent)


def _of_call(function: str, arguments: tuple[Node, ...], slopes: tuple[Node, ...]) -> Node:
    first, slope = arguments[0], slopes[0]
    itself = Call(function, arguments)
    match function:
        case "sin":
            return times(Call("cos", arguments), slope)
        case "cos":
            return negative(times(Call("sin", arguments), slope))
        case "tan":
            return times(plus(ONE, power(itself, TWO)), slope)
        case "exp":
            return times(itself, slope)
        case "log":
            return over(slope, first)
        case "sqrt":
            return over(slope, times(TWO, itself))
        case "abs":
            return choose(Operation("<", first, ZERO), negative(slope), slope)
        case "min":
            return choose(Operation("<=", first, arguments[1]), slope, slopes[1])
        case "max":
            return choose(Operation(">=", first, arguments[1]), slope, slopes[1])
        case "clip":
            _, low, high = arguments
            inside = choose(Operation("<", first, low), slopes[1], slope)
            return choose(Operation(">", first, high), slopes[2], inside)
        case "where":
            return choose(first, slopes[1], slopes[2])
        case _:
            return ZERO


def _folded(node: Node) -> Node:
    try:
        return fold(node)
    except (ArithmeticError, ValueError):
        return node


def negative(operand: Node) -> Node:
    """−a."""
    return operand.operand if isinstance(operand, Negation) else _folded(Negation(operand))


def plus(left: Node, right: Node) -> Node:
    """a + b."""
    if left == ZERO:
        return right
    if right == ZERO:
        return left
    if isinstance(right, Negation):
        return minus(left, right.operand)
    return _folded(Operation("+", left, right))


def minus(left: Node, right: Node) -> Node:
    """a − b."""
    if right == ZERO:
        return left
    if left == ZERO:
        return negative(right)
    if isinstance(right, Negation):
        return plus(left, right.operand)
    return ZERO if left == right else _folded(Operation("-", left, right))


def times(left: Node, right: Node) -> Node:
    """a b, constants and signs to the front."""
    if ZERO in (left, right):
        return ZERO
    if left == ONE:
        return right
    if right == ONE:
        return left
    if isinstance(left, Negation):
        return negative(times(left.operand, right))
    if isinstance(right, Negation):
        return negative(times(left, right.operand))
    if isinstance(right, Number):
        left, right = right, left
    match left, right:
        case Number(a), Operation("*", Number(b), rest) if math.isfinite(a * b):
            return times(Number(a * b), rest)
        case Operation("*", Number() as factor, rest), _:
            return times(factor, times(rest, right))
        case _, Operation("*", Number() as factor, rest) if not isinstance(left, Number):
            return times(factor, times(left, rest))
        case Number(-1.0), _:
            return negative(right)
    return _folded(Operation("*", left, right))


def over(left: Node, right: Node) -> Node:
    """a / b."""
    if left == ZERO:
        return ZERO
    if right == ONE:
        return left
    if isinstance(left, Negation):
        return negative(over(left.operand, right))
    return _folded(Operation("/", left, right))


def power(base: Node, exponent: Node) -> Node:
    """a to the power b."""
    if exponent == ZERO:
        return ONE
    return base if exponent == ONE else _folded(Operation("**", base, exponent))


def choose(condition: Node, chosen: Node, otherwise: Node) -> Node:
    """`chosen` where the condition holds, else `otherwise`."""
    return chosen if chosen == otherwise else _folded(Call("where", (_folded(condition), chosen, otherwise)))

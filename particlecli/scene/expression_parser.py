"""Text to formula: Python's own parser, then a whitelist of what may stand in the tree it gives."""

from __future__ import annotations

import ast
import difflib
import math
import warnings

from particlecli.scene.expression_tree import Call, Negation, Node, Number, Operation, Variable, fold

LONGEST = 2000
"""Characters in an expression."""

DEEPEST = 200
"""Levels of nesting in an expression; a chain of additions counts a level for each."""

SHOWN = 70
"""Characters of an expression that an error message shows."""

CONSTANTS = {"pi": math.pi}
ARGUMENTS = {
    **dict.fromkeys(("sin", "cos", "tan", "exp", "log", "sqrt", "abs", "floor"), (1, 1)),
    **dict.fromkeys(("min", "max"), (2, 16)),
    **dict.fromkeys(("clip", "where"), (3, 3)),
}
"""The functions an expression may call, each with its smallest and largest number of arguments."""

_SYMBOLS: dict[type[ast.AST], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Mod: "%",
    ast.Pow: "**",
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
}
_REFUSED: dict[type[ast.AST], str] = {
    ast.Attribute: "a dot between names has no meaning here",
    ast.Subscript: "square brackets have no meaning here",
    ast.BitXor: "write ** for a power, not ^",
    ast.FloorDiv: "write floor(a / b), not a // b",
    ast.BoolOp: "write (a)*(b) for `a and b`, max(a, b) for `a or b`",
    ast.Not: "write 1 - a for `not a`",
    ast.IfExp: "write where(condition, value, otherwise) for `if` and `else`",
    ast.Starred: "a star before an argument has no meaning here",
}


def show(source: str, place: int, message: str) -> ValueError:
    """An error whose text points at a place in the expression with a caret; of a long one it shows a part."""
    first = max(0, min(place - SHOWN // 2, len(source) - SHOWN))
    excerpt = source[first : first + SHOWN]
    before, after = "…" if first else "", "…" if first + SHOWN < len(source) else ""
    return ValueError(f"{message}\n    {before}{excerpt}{after}\n    {' ' * (len(before) + place - first)}^")


def parse(source: str) -> Node:
    """Parse an expression, constants folded.

    Raises:
        ValueError: it is not one, or holds something outside the language; the text points at the place.
    """
    if not source:
        raise ValueError("an expression must not be empty")
    if len(source) > LONGEST:
        raise ValueError(f"an expression has {LONGEST} characters at most, this one has {len(source)}")
    if "#" in source:
        raise show(source, source.index("#"), "# has no meaning in an expression")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            root = ast.parse(source, mode="eval").body
    except SyntaxError as error:
        place = min(max((error.offset or 1) - 1, 0), len(source))
        raise show(source, place, "this is not an arithmetic expression") from None
    except (RecursionError, MemoryError):
        raise ValueError("the expression is nested too deeply") from None
    except ValueError:
        raise ValueError("the expression holds a character or number that cannot be read") from None
    return _Reader(source).read(root, 1)


class _Reader:
    """Turns nodes of Python's tree into nodes of ours, refusing all that is not on the list."""

    def __init__(self, source: str) -> None:
        self._source = source

    def _error(self, node: ast.expr, message: str) -> ValueError:
        # Python counts bytes; people and carets count characters.
        place = len(self._source.encode()[: node.col_offset].decode(errors="ignore"))
        return show(self._source, place, message)

    def read(self, node: ast.expr, depth: int) -> Node:
        if depth > DEEPEST:
            raise self._error(node, f"the expression is nested deeper than {DEEPEST} levels")
        match node:
            case ast.Constant(value):
                return self._number(node, value)
            case ast.Name(name):
                return self._name(node, name)
            case ast.UnaryOp(ast.UAdd(), operand):
                return self.read(operand, depth + 1)
            case ast.UnaryOp(ast.USub(), operand):
                return self._folded(node, Negation(self.read(operand, depth + 1)))
            case ast.BinOp(left, kind, right) if type(kind) in _SYMBOLS:
                return self._binary(node, self.read(left, depth + 1), kind, right, depth)
            case ast.Compare(left, kinds, rights) if all(type(kind) in _SYMBOLS for kind in kinds):
                return self._comparison(node, [left, *rights], kinds, depth)
            case ast.Call(ast.Name(name), arguments, keywords):
                return self._call(node, name, arguments, keywords, depth)
            case ast.UnaryOp(kind) | ast.BinOp(_, kind, _):
                message = _REFUSED.get(type(kind))
            case _:
                message = _REFUSED.get(type(node))
        raise self._error(node, message or "only arithmetic, comparisons and the known functions are allowed")

    def _number(self, node: ast.expr, value: object) -> Node:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self._error(node, "only numbers, names and functions are allowed")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if math.isinf(number):
            raise self._error(node, "the number is too large")
        return Number(number)

    def _name(self, node: ast.expr, name: str) -> Node:
        if name in ARGUMENTS:
            raise self._error(node, f"`{name}` is a function: write {name}(…)")
        return Number(CONSTANTS[name]) if name in CONSTANTS else Variable(name)

    def _folded(self, node: ast.expr, result: Node) -> Node:
        try:
            return fold(result)
        except (ArithmeticError, ValueError):
            raise self._error(node, "the value of this constant part is not a finite real number") from None

    def _binary(self, node: ast.expr, left: Node, kind: ast.operator, right: ast.expr, depth: int) -> Node:
        symbol, divisor = _SYMBOLS[type(kind)], self.read(right, depth + 1)
        if symbol in "/%" and divisor == Number(0.0):
            raise self._error(right, "division by zero")
        return self._folded(node, Operation(symbol, left, divisor))

    def _comparison(self, node: ast.expr, operands: list[ast.expr], kinds: list[ast.cmpop], depth: int) -> Node:
        # a < b < c means both, and the product of the two masks says so.
        values = [self.read(operand, depth + 1) for operand in operands]
        result: Node | None = None
        for kind, left, right in zip(kinds, values, values[1:], strict=False):
            single = self._folded(node, Operation(_SYMBOLS[type(kind)], left, right))
            result = single if result is None else self._folded(node, Operation("*", result, single))
        assert result is not None
        return result

    def _call(
        self, node: ast.expr, name: str, arguments: list[ast.expr], keywords: list[ast.keyword], depth: int
    ) -> Node:
        if name not in ARGUMENTS:
            nearest = difflib.get_close_matches(name, ARGUMENTS, 1)
            hint = f"did you mean `{nearest[0]}`?" if nearest else f"known are {' '.join(sorted(ARGUMENTS))}"
            raise self._error(node, f"unknown function `{name}`; {hint}")
        if keywords:
            raise self._error(keywords[0].value, "arguments have no names here: write just the value")
        fewest, most = ARGUMENTS[name]
        if not fewest <= len(arguments) <= most:
            wanted = {1: "one argument", 2: f"two to {most} arguments", 3: "three arguments"}[fewest]
            raise self._error(node, f"`{name}` takes {wanted}, not {len(arguments)}")
        values = [self.read(argument, depth + 1) for argument in arguments]
        while name in ("min", "max") and len(values) > 2:
            values[:2] = [self._folded(node, Call(name, tuple(values[:2])))]
        return self._folded(node, Call(name, tuple(values)))

"""What pydantic finds wrong in the words of the scene: where it stands, what is wrong and what to do."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any, NamedTuple, get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from particlecli.errors import Problem
from particlecli.scene.document import KeyPath, Node, Place, written
from particlecli.scene.expression import Expression
from particlecli.scene.language import KEY_OF_MAPPING, Spot, choices, follow, keys, members, peel
from particlecli.scene.types import KeyedError

_KINDS = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "string_type": "text",
    "tuple_type": "a list in square brackets",
    "dict_type": "a mapping of keys to values",
    "model_type": "a mapping of keys to values",
    "model_attributes_type": "a mapping of keys to values",
}
LONGEST = 40
"""Characters of a text that a message shows."""

_BOUNDS = {
    "greater_than": ("gt", "above"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "below"),
    "less_than_equal": ("le", "at most"),
}


def suggestion(word: object, known: Iterable[str], *, whole_list: bool = False) -> str:
    """The question whether the nearest known word was meant; all words if none is near, or if asked for."""
    known = list(known)
    nearest = difflib.get_close_matches(str(word).lower(), known, 1)
    question = f'; did you mean "{nearest[0]}"?' if nearest else ""
    if known and (whole_list or not nearest):
        question += f"{' Known' if nearest else '; known'} here: {', '.join(known)}"
    return question


def from_validation(error: ValidationError, root: Node) -> list[tuple[Place, Problem]]:
    """The problems in a validation error, each with its place, in pydantic's order."""
    details = error.errors(include_url=False)
    locations = {detail["loc"] for detail in details}
    parents = {location[:length] for location in locations for length in range(len(location))}
    found: dict[tuple[KeyPath, str], tuple[Place, Problem]] = {}
    for detail in details:
        # A list whose item is wrong also counts as too short, which says nothing new.
        if detail["type"] == "too_short" and detail["loc"] in parents:
            continue
        told = _told(detail, follow(detail["loc"]), root)
        place = root.locate(told.at or told.path, key=told.about_key)
        found.setdefault((told.path, told.message), (place, problem(told.path, told.message, place)))
    return list(found.values())


def problem(path: KeyPath, message: str, place: Place) -> Problem:
    """A problem at a place."""
    return Problem(written(path), message, place.line, place.column, place.option)


class _Told(NamedTuple):
    """What is wrong with the value at a path, or with its key; shown at `at` where that is another place."""

    path: KeyPath
    message: str
    at: KeyPath = ()
    about_key: bool = False


def _told(detail: ErrorDetails, spot: Spot, root: Node) -> _Told:
    kind, path, value = detail["type"], spot.path, detail["input"]
    match kind:
        case "missing" if isinstance(path[-1], int):
            return _Told(path[:-1], _wrong_length(follow(detail["loc"][:-1]), value))
        case "missing":
            return _Told(path, f"is missing: {spot.description}", at=path[:-1])
        case "extra_forbidden":
            return _Told(path, _unknown_key(path[-1], follow(detail["loc"][:-1])), about_key=True)
        case "union_tag_invalid":
            word, known = value["type"], members(spot.annotation)
            return _Told((*path, "type"), f"unknown type {shown(word)}{suggestion(word, known, whole_list=True)}")
        case "union_tag_not_found":
            return _untagged(spot, value, by_type="'type'" in detail["ctx"]["discriminator"])
    cause = detail.get("ctx", {}).get("error")
    if isinstance(cause, KeyedError):
        return _Told((*path, cause.key), str(cause))
    reached = root.reach(path)
    if reached < len(path) and kind == "string_pattern_mismatch":
        # One word stands for a whole mapping there.
        return _Told(path[:reached], f"must be {follow(path[:reached]).description}")
    return _Told(path[:reached], _message(detail, spot), about_key=KEY_OF_MAPPING in detail["loc"])


def _untagged(spot: Spot, value: Any, *, by_type: bool) -> _Told:
    known = [tag for tag in members(spot.annotation) if tag != "number"]
    if value is None:
        return _Told(spot.path, _wrong_kind("a mapping of keys to values", value, spot))
    if by_type:
        return _Told(spot.path, f"needs a `type`: {', '.join(known)}")
    if isinstance(value, dict) and len(value) == 1:
        key = next(iter(value))
        return _Told((*spot.path, key), f"unknown key{suggestion(key, known)}", about_key=True)
    return _Told(spot.path, f"must be {spot.description}; a mapping has one of the keys {', '.join(known)}")


def _unknown_key(key: object, parent: Spot) -> str:
    known = keys(parent.annotation)
    if difflib.get_close_matches(str(key).lower(), known, 1):
        return f"unknown key{suggestion(key, known)}"
    owners = [tag for tag, member in parent.alternatives if key in keys(member)]
    if owners:
        return f"this key belongs to {' and '.join(owners)}; known here: {', '.join(known)}"
    return f"unknown key{suggestion(key, known)}"


def _wrong_length(spot: Spot, value: Any) -> str:
    items = get_args(peel(spot.annotation)[0])
    noun = "expressions" if peel(items[0])[0] is Expression else "numbers"
    return f"must be {len(items)} {noun}, not {len(value)}"


def _message(detail: ErrorDetails, spot: Spot) -> str:
    kind, value, context = detail["type"], detail["input"], detail.get("ctx", {})
    if kind in _KINDS:
        return _wrong_kind(_KINDS[kind], value, spot)
    if kind in _BOUNDS:
        return _out_of_bounds(kind, context, value)
    match kind:
        case "value_error":
            return str(context["error"])
        case "literal_error":
            return f"unknown choice {shown(value)}{suggestion(value, choices(spot.annotation), whole_list=True)}"
        case "int_parsing_size":
            return "is too large"
        case "finite_number":
            return "must be a finite number"
        case "too_long" if context.get("max_length") == len(get_args(peel(spot.annotation)[0])):
            return _wrong_length(spot, value)
        case "too_short":
            return "must not be empty"
        case "string_pattern_mismatch" if detail["loc"][-1] == KEY_OF_MAPPING:
            return "a name is made of letters, digits and _, and does not begin with a digit"
        case "string_pattern_mismatch" if value.startswith("#") or "#" in context["pattern"]:
            return f'must be a colour such as "#ff8800", not {shown(value)}'
        case "string_pattern_mismatch":
            return f"{shown(value)} is not a name: letters, digits and _, no digit first"
    return detail["msg"]


def _wrong_kind(wanted: str, value: Any, spot: Spot) -> str:
    if value is None:
        remedy = (
            'a colour needs quotes, as # begins a comment: "#ff8800"'
            if "rrggbb" in spot.description or "colour" in spot.description
            else ""
        )
        return f"has no value; {remedy or f'it must be {wanted}, or delete the key'}"
    about = f" ({spot.description})" if spot.description else ""
    return f"must be {wanted}, not {shown(value)}{about}"


def _out_of_bounds(kind: str, context: dict[str, Any], value: Any) -> str:
    name, words = _BOUNDS[kind]
    bound = context[name]
    if (name, bound) == ("gt", 0):
        return f"must be positive, and is {shown(value)}"
    if (name, bound) == ("ge", 0):
        return f"must not be negative, and is {shown(value)}"
    return f"must be {words} {bound:g}, not {shown(value)}"


def shown(value: Any) -> str:
    """A value as it may stand in a sentence."""
    match value:
        case None:
            return "nothing"
        case bool():
            return "true" if value else "false"
        case dict():
            return "a mapping"
        case list() | tuple():
            return "a list"
        case str():
            return f'"{value[:LONGEST]}…"' if len(value) > LONGEST else f'"{value}"'
    return f"{value:g}" if isinstance(value, float) else str(value)

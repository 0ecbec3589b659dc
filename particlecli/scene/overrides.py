"""`key=value` from the command line, put into a scene's document before it is validated."""

from __future__ import annotations

import re
from dataclasses import replace

from particlecli.errors import Problem
from particlecli.scene.document import KeyPath, Node, Place, written
from particlecli.scene.messages import suggestion
from particlecli.scene.reader import DocumentError, parse

NAMED = ("flows", "particles", "emitters")
"""Mappings whose keys the user makes up; a step through one must not make up another by a slip of the pen."""

_INDEX = re.compile(r"[0-9]+")


def override(root: Node, assignment: str) -> list[Problem]:
    """Put `dotted.key=yaml value` into a document; returns what is wrong with it.

    Steps are keys and, for lists, numbers from 0: `forces.0.coefficient` or `forces[0].coefficient`. Keys
    missing on the way come into being; whether the language knows them is for the validation to say.
    """
    keys, equals, text = assignment.partition("=")
    option = f"--set {keys.strip()}"
    path = _steps(keys)
    if not equals or "" in path:
        message = "write it as key=value, such as integrator.dt=0.01"
        return [Problem("", message, option=f"--set {assignment}")]
    try:
        value, problems = parse(text, option)
        if problems:
            return problems
        place = Place(option=option)
        _refuse_made_up_name(root, path)
        changed = _with(root, path, 0, value or Node(None, place), place)
        root.value, root.key_places = changed.value, changed.key_places
    except DocumentError as error:
        return [error.problem]
    except ValueError as error:
        return [Problem(written(path), str(error), option=option)]
    return []


def _steps(keys: str) -> KeyPath:
    steps = keys.strip().replace("[", ".").replace("]", "").split(".")
    return tuple(int(step) if _INDEX.fullmatch(step) else step.strip() for step in steps)


def _with(node: Node, path: KeyPath, depth: int, value: Node, place: Place) -> Node:
    """A copy of the node, as aliases may share it, in which the path from a depth on leads to the value."""
    if depth == len(path):
        return value
    step, here = path[depth], written(path[:depth])
    if isinstance(node.value, list):
        if not isinstance(step, int):
            raise ValueError(f"{here} is a list: the next step must be a number below {len(node.value)}")
        if step >= len(node.value):
            raise ValueError(f"{here} has {len(node.value)} entries, counted from 0")
        below = _with(node.value[step], path, depth + 1, value, place)
        return replace(node, value=[*node.value[:step], below, *node.value[step + 1 :]])
    if isinstance(step, int):
        raise ValueError(f"{here} is not given as a list in the scene; give the whole list")
    entries, places = (node.value, node.key_places) if isinstance(node.value, dict) else ({}, {})
    below = _with(entries.get(step) or Node({}, place), path, depth + 1, value, place)
    return Node({**entries, step: below}, node.place, {step: place, **places})


def _refuse_made_up_name(root: Node, path: KeyPath) -> None:
    if len(path) > 2 and path[0] in NAMED and root.reach(path[:2]) < 2:
        named = root.child(path[0])
        known = list(named.value) if named and isinstance(named.value, dict) else []
        raise ValueError(f'there is no "{path[1]}" in {path[0]}{suggestion(path[1], known)}')

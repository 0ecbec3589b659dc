"""A document as a tree that remembers where everything stands."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

KeyPath = tuple[str | int, ...]
"""Keys and indices that lead to a value."""

_STEP = re.compile(r"\[(\d+)\]|([^.\[\]]+)")


def written(path: KeyPath) -> str:
    """A path as people write it: `forces[2].coefficient`."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return text.removeprefix(".")


def unwritten(text: str) -> KeyPath:
    """The path that was written so."""
    return tuple(int(index) if index else key for index, key in _STEP.findall(text))


@dataclass(frozen=True, slots=True)
class Place:
    """Line and column, both from 1, or the command-line option that a value came from."""

    line: int | None = None
    column: int | None = None
    option: str | None = None

    @property
    def order(self) -> tuple[bool, int, int]:
        """Sorts places in the order of the file, options after it."""
        return self.line is None, self.line or 0, self.column or 0


@dataclass(slots=True)
class Node:
    """A value: a scalar (None, bool, int, float, str), a list of nodes, or a dict from keys to nodes.

    Attributes:
        key_places: where each key of a mapping stands.
        size: how many values there are in it, itself included and aliases expanded.
    """

    value: Any
    place: Place
    key_places: dict[str, Place] = field(default_factory=dict)
    size: int = 1

    def plain(self) -> Any:
        """The value as plain data."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        return self.value

    def child(self, step: str | int) -> Node | None:
        """What is under a key or at an index."""
        if isinstance(self.value, dict):
            return self.value.get(str(step))
        if isinstance(self.value, list) and isinstance(step, int) and 0 <= step < len(self.value):
            node: Node = self.value[step]
            return node
        return None

    def reach(self, path: KeyPath) -> int:
        """How many steps of a path exist."""
        node: Node | None = self
        for count, step in enumerate(path):
            node = node.child(step) if node else None
            if node is None:
                return count
        return len(path)

    def locate(self, path: KeyPath, *, key: bool = False) -> Place:
        """Where the value at a path stands, or the nearest that exists on the way to it.

        A mapping, and whatever begins below its key, is shown at the key; `key` asks for the key in any case.
        """
        place: Place = self.place
        node: Node = self
        for number, step in enumerate(path[: self.reach(path)], start=1):
            above, node = node, node.child(step) or node
            place = node.place
            if isinstance(above.value, dict):
                at_key = above.key_places[str(step)]
                asked = key and number == len(path)
                below = isinstance(node.value, dict) or place.line != at_key.line
                if asked or (below and place.option is None):
                    place = at_key
        return place

"""YAML text to a document.

PyYAML's own composer recurses, and crashes the process on deep nesting; here its events are put together
one by one, with bounds on depth and on what aliases may expand to.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NoReturn

import yaml

from particlecli.errors import Problem
from particlecli.scene import scalars
from particlecli.scene.document import Node, Place, written
from particlecli.scene.yaml_messages import explain

LONGEST = 8_000_000
"""Characters in a scene file."""

MOST_VALUES = 1_000_000
"""Keys and values in a scene, aliases expanded."""

DEEPEST = 40
"""Levels of nesting."""

SHOWN = 8
"""Levels of a path that a message about the text itself still shows."""

_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff\ufffe\uffff]")


class DocumentError(ValueError):
    """A text that is no document a scene can be made of; carries the problem that stopped the reading."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        super().__init__(problem.message)


def parse(text: str, option: str | None = None) -> tuple[Node | None, list[Problem]]:
    """Read one YAML document: its root, None when the text has nothing in it, and the problems found.

    Problems are what scenes do not have but can be read past: repeated keys, keys that are not plain words,
    tags, merge keys.

    Args:
        text: the document.
        option: the command-line option that the text comes from, when it is not a file.

    Raises:
        DocumentError: it is too long, not YAML, more than one document, nested too deeply, or has aliases
            that contain themselves or expand to too much.
    """
    if len(text) > LONGEST:
        message = f"is longer than {LONGEST:,} characters; put particle lists into a .csv or .npz file"
        raise DocumentError(Problem("", message))
    _refuse_control_characters(text, option)
    composer = _Composer(option)
    try:
        for event in yaml.parse(text, Loader=yaml.CSafeLoader):
            composer.take(event)
    except yaml.YAMLError as error:
        message, line, column = explain(error, text)
        raise DocumentError(Problem("", message, line, column, option)) from None
    return composer.root, composer.problems


def _refuse_control_characters(text: str, option: str | None) -> None:
    found = _CONTROL.search(text)
    if found is None:
        return
    binary = found[0] == "\0"
    message = "this is not a text file" if binary else "a control character does not belong here"
    line = text.count("\n", 0, found.start()) + 1
    column = found.start() - text.rfind("\n", 0, found.start())
    raise DocumentError(Problem("", message, line, column, option))


@dataclass(slots=True)
class _Open:
    """A list or mapping whose end has not come yet, and the key that waits for its value."""

    node: Node
    anchor: str | None
    key: str | None = None


class _Composer:
    """Builds the tree from events."""

    def __init__(self, option: str | None) -> None:
        self.root: Node | None = None
        self.problems: list[Problem] = []
        self._option = option
        self._open: list[_Open] = []
        self._anchors: dict[str, Node | None] = {}
        self._documents = 0

    def take(self, event: yaml.Event) -> None:
        place = self._place(event)
        if isinstance(event, yaml.DocumentStartEvent):
            self._documents += 1
            if self._documents > 1:
                self._refuse(place, "a second document begins here; a scene file holds one")
        elif isinstance(event, yaml.CollectionEndEvent):
            self._close()
        elif isinstance(event, yaml.AliasEvent):
            self._add(self._resolve(event.anchor or "", place), place)
        elif isinstance(event, (yaml.ScalarEvent, yaml.CollectionStartEvent)):
            self._begin(event, place)

    def _begin(self, event: yaml.ScalarEvent | yaml.CollectionStartEvent, place: Place) -> None:
        tag = event.tag
        if tag is not None and not (tag == "!" and isinstance(event, yaml.ScalarEvent)):
            self._report(place, f"the tag {tag} has no meaning in a scene; delete it")
        if isinstance(event, yaml.ScalarEvent):
            # Only plain scalars have a meaning of their own; quoted ones, and keys, are what they say.
            is_key = bool(self._open) and self._waits_for_key()
            value = scalars.resolve(event.value) if event.implicit[0] and not is_key else event.value
            node = Node(value, place)
            if event.anchor:
                self._anchors[event.anchor] = node
            self._add(node, place)
            return
        if len(self._open) >= DEEPEST:
            self._refuse(place, f"nested deeper than {DEEPEST} levels")
        node = Node([] if isinstance(event, yaml.SequenceStartEvent) else {}, place)
        if event.anchor:
            self._anchors[event.anchor] = None
        self._open.append(_Open(node, event.anchor))

    def _close(self) -> None:
        closed = self._open.pop()
        if closed.anchor:
            self._anchors[closed.anchor] = closed.node
        self._add(closed.node, closed.node.place)

    def _resolve(self, anchor: str, place: Place) -> Node:
        if anchor not in self._anchors:
            self._refuse(place, f"*{anchor} refers to nothing: there is no &{anchor} above")
        node = self._anchors[anchor]
        if node is None:
            self._refuse(place, f"*{anchor} stands within &{anchor} itself, so it would never end")
        return node

    def _add(self, node: Node, place: Place) -> None:
        if not self._open:
            self.root = node
            return
        parent = self._open[-1]
        if self._waits_for_key():
            self._set_key(parent, node, place)
            return
        # An alias is counted with all it stands for, so doubling again and again meets the bound early.
        parent.node.size += node.size
        if parent.node.size > MOST_VALUES:
            self._refuse(
                place,
                f"more than {MOST_VALUES:,} values; put lists into a .csv or .npz file",
            )
        if isinstance(parent.node.value, dict):
            if parent.key in parent.node.key_places:
                parent.node.value.setdefault(parent.key, node)
            parent.key = None
        else:
            parent.node.value.append(node)

    def _waits_for_key(self) -> bool:
        return isinstance(self._open[-1].node.value, dict) and self._open[-1].key is None

    def _set_key(self, parent: _Open, node: Node, place: Place) -> None:
        if isinstance(node.value, (dict, list)):
            self._report(place, "a key must be a plain word, not a list or mapping")
            parent.key = ""
            return
        parent.key = key = str(node.value)
        if key in parent.node.key_places:
            first = parent.node.key_places[key]
            where = f" in line {first.line}" if first.line else ""
            self._report(place, f"this key stands here twice; the first is{where or ' before it'}")
        elif key == "<<":
            self._report(place, "merging with << is not part of the language; write the keys out")
        else:
            parent.node.key_places[key] = place

    def _place(self, event: yaml.Event) -> Place:
        if self._option or event.start_mark is None:
            return Place(option=self._option)
        return Place(event.start_mark.line + 1, event.start_mark.column + 1)

    def _path(self) -> str:
        if len(self._open) > SHOWN:
            return ""
        steps = [len(each.node.value) if isinstance(each.node.value, list) else each.key for each in self._open]
        return written(tuple(step for step in steps if step is not None))

    def _report(self, place: Place, message: str) -> None:
        self.problems.append(Problem(self._path(), message, place.line, place.column, place.option))

    def _refuse(self, place: Place, message: str) -> NoReturn:
        self._report(place, message)
        raise DocumentError(self.problems[-1])

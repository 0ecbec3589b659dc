"""A scene as YAML: all defaults filled in, vectors and short mappings on one line."""

from __future__ import annotations

import re
from typing import Any

import yaml
from yaml.representer import SafeRepresenter

from particlecli.scene import scalars
from particlecli.scene.language import reading_order
from particlecli.scene.model import Scene

WIDEST = 88
"""Characters that a list or mapping may take on one line, indentation not counted."""

ENDLESS = 1_000_000_000
"""A line width at which nothing is folded."""


def dump_scene(scene: Scene) -> str:
    """The scene as YAML text with every default written out; what is absent by default is left out.

    From a file of that text in the same folder, `load_scene` makes an equal scene.
    """
    data = scene.model_dump(by_alias=True, exclude_none=True)
    text, long = "", False
    for key, value in data.items():
        section = _section(key, value)
        before, long = long, section.count("\n") > 1
        text += f"\n{section}" if text and (before or long) else section
    return text


class _Representer(SafeRepresenter):
    def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002 - shared defaults are no aliases
        return True

    def represent_keys(self, data: dict[str, Any]) -> yaml.MappingNode:
        """Represents a mapping, its keys in reading order."""
        ordered = {key: data[key] for key in sorted(data, key=reading_order)}
        return self.represent_mapping("tag:yaml.org,2002:map", ordered.items())


_Representer.add_representer(dict, _Representer.represent_keys)


class _Dumper(yaml.CSafeDumper):
    """Quotes what the scene language, rather than YAML 1.1, would read as something else than text."""


# PyYAML matches beginnings only, and None stands for any first character.
_Dumper.yaml_implicit_resolvers = {
    None: [
        (f"tag:yaml.org,2002:{kind}", re.compile(rf"(?:{pattern.pattern})\Z"))
        for kind, pattern in (
            ("null", scalars.NULL),
            ("bool", scalars.BOOL),
            ("int", scalars.INT),
            ("int", scalars.OTHER_BASE),
            ("float", scalars.FLOAT),
        )
    ]
}


def _section(key: str, value: Any) -> str:
    node: Any = _Representer().represent_data({key: value})
    node.flow_style = False
    _fold(node.value[0][1], len(key) + 2)
    text: str = yaml.serialize(node, Dumper=_Dumper, allow_unicode=True, width=ENDLESS)
    return text


def _fold(node: Any, before: int) -> None:
    """Put a node on one line if it fits there after so many characters, else its parts where they fit."""
    if isinstance(node, yaml.ScalarNode):
        return
    node.flow_style = before + _width(node) <= WIDEST
    if node.flow_style:
        return
    for part in node.value:
        key, value = part if isinstance(part, tuple) else (None, part)
        _fold(value, 2 if key is None else _width(key) + 2)


def _width(node: Any) -> int:
    if isinstance(node, yaml.ScalarNode):
        return len(node.value)
    total = 2
    for part in node.value:
        total += 2 + sum(map(_width, part)) + 2 if isinstance(part, tuple) else 2 + _width(part)
        if total > WIDEST:
            break
    return total

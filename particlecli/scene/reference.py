"""The reference of the scene language, made from the models: JSON Schema for editors, Markdown for people."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic.json_schema import GenerateJsonSchema
from pydantic_core import PydanticUndefined

from particlecli.scene.distributions import AnyNumber
from particlecli.scene.expression import FUNCTION_NAMES, Expression, Uses
from particlecli.scene.flows import FlowTerm
from particlecli.scene.forces import Force
from particlecli.scene.known_answers import Tolerance
from particlecli.scene.language import choices, fields, is_model, is_union, members, peel
from particlecli.scene.local_forces import Viscosity
from particlecli.scene.look import Color, ColorMap
from particlecli.scene.model import Scene
from particlecli.scene.outputs import Output
from particlecli.scene.planes import Friction
from particlecli.scene.shapes import Layout, Shape
from particlecli.scene.types import Direction, HexColor, Name, RelativeFile

UNIONS: dict[str, Any] = {
    "Flow": FlowTerm,
    "Layout": Layout,
    "Shape": Shape,
    "Distribution": AnyNumber,
    "Force": Force,
    "Friction": Friction,
    "Viscosity": Viscosity,
    "Tolerance": Tolerance,
    "Color": Color,
    "Output": Output,
}
"""Titles of the unions that have a section of their own."""

UNSAID = 1e9
"""Bounds as large as this keep numbers in the machine's range, and say nothing to a reader."""

FUNCTIONS = " ".join(f"`{name}`" for name in FUNCTION_NAMES)

INTRODUCTION = f"""\
<!-- Made by `particlecli schema --markdown > scenes/README.md`; change the models, not this file. -->

# The scene language

A scene is a YAML file; `particlecli run scene.yaml` makes pictures of it. Units are SI, axes are right-handed
and y is up.

- **Keys** that are not in these tables are errors, and so are keys written twice.
- **Numbers** mean what they look like: `1e3` is 1000 and `010` is ten. Only `true` and `false` are truth
  values; `yes`, `no`, `on` and `off` are words.
- **Vectors** are three numbers in brackets. A **direction** is a vector of any length but zero.
- **Names** of groups and flows are made of letters, digits and `_`, and do not begin with a digit.
- **Expressions** are numbers, or text made of `+ - * / % **`, comparisons (1 where they hold, else 0), `pi`,
  {FUNCTIONS},
  and the names that their key allows.
- **Files** that a scene names are beside or below it, and what it writes stays in the output folder.
- Any value can be changed from the command line: `--set integrator.dt=0.01 --set 'forces[0].on=[sparks]'`.

`particlecli schema` prints the same as a JSON Schema, with which editors complete and check scenes.

| glow and streaks | clear spheres | ribbons and spheres | surface |
|---|---|---|---|
| ![Fireworks](pictures/fireworks.jpg) | ![Bubbles](pictures/bubbles.jpg) | ![A robot arm](pictures/robot_arm.jpg) | \
![A flag](pictures/flag.jpg) |
| **ribbons of hair** | **sprites of leaves** | **a million that glow** | **surface with shadows** |
| ![Hair](pictures/hair.jpg) | ![Autumn](pictures/autumn.jpg) | ![Sparks](pictures/million_sparks.jpg) | \
![Jelly](pictures/jelly.jpg) |
| **blobs** | **dots and spheres** | **streaks** | **glow** |
| ![A lava lamp](pictures/lava_lamp.jpg) | ![A snake](pictures/snake.jpg) | ![A fountain](pictures/fountain.jpg) | \
![A campfire](pictures/campfire.jpg) |
| **streaks of snow** | **smoke that glows** | **streaks of fire** | **streaks and glow** |
| ![Snow](pictures/snow.jpg) | ![Smoke](pictures/smoke.jpg) | ![A fire whirl](pictures/fire_whirl.jpg) | \
![Solar wind](pictures/solar_wind.jpg) |
"""


class _Untitled(GenerateJsonSchema):
    """Leaves out titles that only repeat a key."""

    def field_title_should_be_set(self, schema: Any) -> bool:  # noqa: ARG002
        return False


def json_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a scene file, with descriptions."""
    schema = Scene.model_json_schema(schema_generator=_Untitled)
    return {"$schema": GenerateJsonSchema.schema_dialect, **schema}


def markdown() -> str:
    """The reference of all keys: a section for each model, in the order in which a reader meets them."""
    sections: dict[str, str] = {}
    _add_model("Scene", Scene, sections)
    return "\n".join([INTRODUCTION, *sections.values()])


def _add_model(title: str, model: type[BaseModel], sections: dict[str, str]) -> None:
    if title in sections:
        return
    sections[title] = f"## {title}\n\n{_description(model)}\n\n{_table(model)}\n"
    for annotation, _ in fields(model).values():
        _add_mentioned(annotation, sections)


def _add_mentioned(annotation: Any, sections: dict[str, str]) -> None:
    """Add the sections of all that an annotation mentions."""
    inner, _ = peel(annotation)
    title = _union_title(inner)
    if title and title not in sections:
        sections[title] = _union_section(title)
        for member in members(UNIONS[title]).values():
            for below, _ in fields(peel(member)[0]).values() if is_model(peel(member)[0]) else ():
                _add_mentioned(below, sections)
    elif is_model(inner):
        _add_model(_model_title(inner), inner, sections)
    elif get_origin(inner) in (tuple, dict):
        for part in get_args(inner):
            _add_mentioned(part, sections)


def _union_section(title: str) -> str:
    text = f"## {title}\n"
    for tag, member in members(UNIONS[title]).items():
        model, _ = peel(member)
        if not is_model(model):
            continue
        heading = f"`type: {tag}`" if "type" in fields(model) else f"`{tag}`"
        table = _table(model)
        text += f"\n### {title}: {heading}\n\n{_description(model)}\n" + (f"\n{table}\n" if table else "")
    return text


def _description(model: type[BaseModel]) -> str:
    return " ".join((model.__doc__ or "").split())


def _table(model: type[BaseModel]) -> str:
    rows = list(_rows(model))
    return "\n".join(["| key | value | default | meaning |", "|---|---|---|---|", *rows]) if rows else ""


def _rows(model: type[BaseModel]) -> Iterator[str]:
    for key, (annotation, field) in fields(model).items():
        if key == "type" and len(choices(annotation)) == 1:
            continue
        cells = (f"`{key}`", _value(annotation, field.metadata), _default(field), field.description or "")
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def _default(field: FieldInfo) -> str:
    default = field.get_default()
    if default is PydanticUndefined:
        return "**required**"
    if default is None or default in ((), {}, ""):
        return ""
    if isinstance(default, BaseModel):
        given = default.model_dump(exclude_defaults=True)
        return f"`{_written(given)}`" if given else ""
    return f"`{_written(default)}`"


def _written(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_written(each)}" for key, each in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_written, value))}]"
    if isinstance(value, Expression):
        return str(value.plain)
    if isinstance(value, float):
        return f"{value:.12g}"
    return value if isinstance(value, str) and value[:1] != "#" else json.dumps(value)


def _value(annotation: Any, around: list[Any] | tuple[Any, ...] = ()) -> str:
    """What may stand at a key, in words."""
    inner, metadata = peel(annotation)
    title = _union_title(inner)
    if title == "Distribution":
        return "number or [distribution](#distribution)"
    if title:
        return f"[{title.lower()}](#{title.lower()})"
    if annotation == ColorMap:
        return " ".join(f"`{name}`" for name in choices(members(ColorMap)["palette"])) + " or list of colours"
    if peel(Direction)[0] == inner and any(each in get_args(Direction)[1:] for each in metadata):
        return "direction"
    if is_model(inner):
        return f"[{_model_title(inner).lower()}](#{_model_title(inner).lower().replace(' ', '-')})"
    if choices(inner):
        return " ".join(f"`{_written_choice(choice)}`" for choice in get_args(inner))
    if inner is Expression:
        names = next((each.names for each in metadata if isinstance(each, Uses)), ())
        return f"expression of {', '.join(names)}"
    if parts := members(annotation):
        return " or ".join(_value(member) for member in parts.values())
    if get_origin(inner) is tuple:
        return _list(get_args(inner))
    if get_origin(inner) is dict:
        return f"by name: {_value(get_args(inner)[1])}"
    if inner is str:
        return _text(metadata)
    return _scalar(inner, [*metadata, *around])


def _text(metadata: tuple[Any, ...]) -> str:
    if any(each in get_args(Name)[1:] for each in metadata):
        return "name"
    if any(each in get_args(HexColor)[1:] for each in metadata):
        return 'colour `"#rrggbb"`'
    return "path" if any(isinstance(each, RelativeFile) for each in metadata) else "text"


def _written_choice(choice: Any) -> str:
    return json.dumps(choice) if isinstance(choice, bool) else str(choice)


def _list(items: tuple[Any, ...]) -> str:
    each = _value(items[0])
    if items[-1] is Ellipsis:
        return f"list of {_plural(each)}"
    return "vector" if len(items) == 3 and each == "number" else f"{len(items)} {_plural(each)}"


def _plural(words: str) -> str:
    return re.sub(r"\b(number|expression|distribution|vector|name)\b(?!\))", r"\1s", words)


def _scalar(kind: Any, metadata: list[Any]) -> str:
    words = {float: "number", int: "whole number", bool: "`true` `false`"}.get(kind, "anything")
    limits = {
        type(limit): bound
        for each in metadata
        for limit in (each.metadata if isinstance(each, FieldInfo) else [each])
        if isinstance(limit, (Ge, Gt, Le, Lt)) and abs(bound := _bound(limit)) < UNSAID
    }
    if Ge in limits and Le in limits:
        return f"{words} from {limits[Ge]} to {limits[Le]}"
    signs = {Ge: "≥", Gt: ">", Le: "≤", Lt: "<"}
    return " ".join([words, *(f"{signs[kind]} {bound}" for kind, bound in limits.items())])


def _bound(limit: Ge | Gt | Le | Lt) -> Any:
    match limit:
        case Ge(bound) | Gt(bound) | Le(bound) | Lt(bound):
            return bound


def _union_title(inner: Any) -> str | None:
    if not is_union(inner):
        return None
    return next((title for title, union in UNIONS.items() if peel(union)[0] == inner), None)


def _model_title(model: type[BaseModel]) -> str:
    """The class's name in words: `GroupLook` becomes `Group look`."""
    spaced = "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in model.__name__)
    return spaced.strip().capitalize()

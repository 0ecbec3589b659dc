"""The language that the models make up: what may stand where, found by walking their annotations."""

from __future__ import annotations

import types
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel, Discriminator, Tag
from pydantic.fields import FieldInfo

from particlecli.scene.document import KeyPath
from particlecli.scene.model import Scene

KEY_OF_MAPPING = "[key]"
"""What pydantic appends to a location when it means a mapping's key itself."""


@dataclass(frozen=True)
class Spot:
    """A place in the language.

    Attributes:
        path: keys and indices that lead there.
        annotation: what may stand there.
        field: the model field it belongs to; none at the root.
        alternatives: the union that it is a member of, by tag; empty where it is none.
    """

    path: KeyPath
    annotation: Any
    field: FieldInfo | None = None
    alternatives: tuple[tuple[str, Any], ...] = ()

    @property
    def description(self) -> str:
        """What the key is for, and its unit."""
        return (self.field.description or "") if self.field else ""


def peel(annotation: Any) -> tuple[Any, tuple[Any, ...]]:
    """An annotation without `Annotated` and `| None`, and the metadata that was around it."""
    metadata: tuple[Any, ...] = ()
    while True:
        if get_origin(annotation) is Annotated:
            annotation, *around = get_args(annotation)
            metadata = (*metadata, *around)
        elif is_union(annotation) and type(None) in get_args(annotation):
            rest = tuple(member for member in get_args(annotation) if member is not type(None))
            annotation = Union[rest]  # noqa: UP007 - built from a tuple
        else:
            return annotation, metadata


def is_union(annotation: Any) -> bool:
    """Whether it is a union of types."""
    return get_origin(annotation) in (Union, types.UnionType)


def is_model(annotation: Any) -> bool:
    """Whether it is one of the scene's models."""
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def members(annotation: Any) -> dict[str, Any]:
    """The members of a tagged union by tag; empty for anything else."""
    union, metadata = peel(annotation)
    if not is_union(union):
        return {}
    key = next((each.discriminator for each in metadata if isinstance(each, (FieldInfo, Discriminator))), None)
    return {_tag(member, key): member for member in get_args(union)} if key else {}


def _tag(member: Any, key: Any) -> str:
    model, metadata = peel(member)
    tag = next((each.tag for each in metadata if isinstance(each, Tag)), None)
    return tag or str(get_args(fields(model)[key][0])[0])


@cache
def fields(model: type[BaseModel]) -> dict[str, tuple[Any, FieldInfo]]:
    """The keys of a model as written in a scene, each with its annotation and field, in reading order."""
    hints = get_type_hints(model, include_extras=True)
    found = {info.alias or name: (hints[name], info) for name, info in model.model_fields.items()}
    return {key: found[key] for key in sorted(found, key=reading_order)}


def reading_order(key: str) -> int:
    """Sorts the keys of a mapping: what it is before all else, and whom it acts on after."""
    return {"type": -1, "on": 1}.get(key, 0)


def follow(location: KeyPath) -> Spot:
    """The place that a location in a pydantic error means; the tags of unions in it are passed by."""
    here = Spot((), Scene)
    for step in location:
        tagged = members(here.annotation)
        inner, _ = peel(here.annotation)
        if tagged:
            here = replace(here, annotation=tagged[str(step)], alternatives=tuple(tagged.items()))
        elif is_model(inner) and step in fields(inner):
            annotation, field = fields(inner)[str(step)]
            here = Spot((*here.path, step), annotation, field)
        elif get_origin(inner) is tuple and isinstance(step, int):
            items = get_args(inner)
            item = items[0] if items[-1] is Ellipsis else items[min(step, len(items) - 1)]
            here = Spot((*here.path, step), item, here.field)
        elif get_origin(inner) is dict and step != KEY_OF_MAPPING:
            here = Spot((*here.path, step), get_args(inner)[1], here.field)
        elif step != KEY_OF_MAPPING:
            here = Spot((*here.path, step), Any, here.field)
    return here


def choices(annotation: Any) -> tuple[str, ...]:
    """The words that may stand at a place, where it is a choice of words."""
    inner, _ = peel(annotation)
    return tuple(map(str, get_args(inner))) if get_origin(inner) is Literal else ()


def keys(annotation: Any) -> tuple[str, ...]:
    """The keys that may stand at a place, where it is a model."""
    inner, _ = peel(annotation)
    return tuple(fields(inner)) if is_model(inner) else ()

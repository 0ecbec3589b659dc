"""Checks of the look: whether groups have what they are to be drawn by."""

from __future__ import annotations

from collections.abc import Iterator

from particlecli.scene.group_checks import Found, has_temperature, missing_file
from particlecli.scene.groups import Emitter, Particles
from particlecli.scene.look import Blackbody, GroupLook, Mapped
from particlecli.scene.messages import suggestion
from particlecli.scene.model import Scene
from particlecli.scene.shapes import GridLayout, HairLayout, LineLayout


def look_problems(scene: Scene) -> Iterator[Found]:
    """What is wrong with the look of a scene's groups."""
    for name, look in scene.look.groups.items():
        path = ("look", "groups", name)
        if name not in scene.groups:
            yield path, f'there is no group "{name}"{suggestion(name, scene.groups)}'
            continue
        for key, message in _group(scene, scene.groups[name], look):
            yield (*path, *key), message


def _group(scene: Scene, group: Particles | Emitter, look: GroupLook) -> Iterator[Found]:
    if look.as_ == "streaks" and group.motion == "first_order":
        yield ("as",), "a first_order group has no velocity to draw streaks along; draw it as dots or glow"
    if look.liquid and look.liquid.stretch > 0 and group.motion == "first_order":
        yield ("liquid", "stretch"), "a first_order group has no velocity to draw blobs out along; leave it at 0"
    if look.image is not None:
        yield from missing_file(scene.folder, "sheet", look.image)
    yield from _joined(group, look)
    for key in ("fade_in", "fade_out"):
        if getattr(look, key) > 0 and group.lifetime is None:
            yield (key,), "is a share of the lifetime, and the group lives on; give it a `lifetime`"
    color = look.color
    if isinstance(color, Blackbody) and not has_temperature(scene, group):
        yield ("color",), "a blackbody has a temperature; give the group one"
    if isinstance(color, Mapped):
        yield from _mapped(scene, group, color)


def _joined(group: Particles | Emitter, look: GroupLook) -> Iterator[Found]:
    """Looks that join particles need to know which."""
    layout = group.layout if isinstance(group, Particles) else None
    if look.as_ == "ribbons":
        listed = isinstance(group, Particles) and len(group.positions or ()) > 1
        if not listed and not isinstance(layout, (LineLayout, HairLayout)):
            yield ("as",), "ribbons join the particles of a `line` or `hair` layout, or two or more `positions`"
    elif look.as_ == "surface" and not (
        isinstance(layout, GridLayout) and sum(count > 1 for count in layout.counts) > 1
    ):
        yield ("as",), "a surface is a skin over a `grid` layout with two particles or more along two of its axes"


def _mapped(scene: Scene, group: Particles | Emitter, color: Mapped) -> Iterator[Found]:
    path = ("color", "by")
    match color.by:
        case "temperature" if not has_temperature(scene, group):
            yield path, "the group has no temperature; give it one, or colour it by something else"
        case "speed" if group.motion == "first_order":
            yield path, "a first_order group has no velocity; colour it by something else"
        case "age" if group.lifetime is None and color.range is None:
            yield (
                path,
                "the group lives on, so ages need a range: [youngest, oldest] in s; or give it a `lifetime`",
            )

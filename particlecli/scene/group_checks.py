"""Checks of groups: their flows, their files, and whether what they are born with fits what they do."""

from __future__ import annotations

import csv
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from particlecli.scene.document import KeyPath
from particlecli.scene.extents import extent
from particlecli.scene.groups import Box, Emitter, Particles
from particlecli.scene.messages import suggestion
from particlecli.scene.model import Scene
from particlecli.scene.types import Vector3

Found = tuple[KeyPath, str]
"""The path of a key and what is wrong there."""

SAMPLES = 1001
"""Instants at which a rate that changes with time is tried."""

ROUNDING = 1e-9
"""How far, in parts of the box, a layout may stand out of it."""

OF_VELOCITY = ("mass", "masses", "speed", "direction", "velocity", "velocities")
"""Keys that mean something to newtonian groups only."""


OF_CHANGE = ("flow", "lifetime", "cooling", "dies", "children")
"""Keys that mean something to groups that change with time only."""


def group_problems(scene: Scene) -> Iterator[Found]:
    """What is wrong with the groups of a scene."""
    if not scene.groups:
        yield (), "there is nothing to simulate: give `particles` or `emitters`"
    for name in scene.emitters:
        if name in scene.particles:
            yield ("emitters", name), "`particles` have a group of this name too; give one another name"
    for name, particles in scene.particles.items():
        for path, message in _particles(scene, particles):
            yield ("particles", name, *path), message
    for name, emitter in scene.emitters.items():
        for path, message in _emitter(scene, name, emitter):
            yield ("emitters", name, *path), message


def has_temperature(scene: Scene, group: Particles | Emitter) -> bool:
    """Whether the particles of a group have a temperature, from the scene or from the group's file."""
    if group.temperature is not None or isinstance(group, Emitter):
        return group.temperature is not None
    in_file = group.file is not None and not {"temperature", "temperatures"}.isdisjoint(
        _quantities(scene.folder / group.file)
    )
    return in_file or group.temperatures is not None


def missing_frame(scene: Scene, path: KeyPath, name: str | None) -> Iterator[Found]:
    """The problem that there is no such coordinate frame, if there is none."""
    if name is not None and name not in scene.frames:
        yield path, f'there is no frame "{name}"{suggestion(name, scene.frames)}'


def missing_flow(scene: Scene, path: KeyPath, name: str) -> Iterator[Found]:
    """The problem that there is no such flow, if there is none."""
    if name not in scene.flows:
        yield path, f'there is no flow "{name}"{suggestion(name, scene.flows)}'


def _particles(scene: Scene, group: Particles) -> Iterator[Found]:
    yield from _common(scene, group)
    if group.file is not None:
        yield from missing_file(scene.folder, "file", group.file)
    box = group.dies.outside
    if box is None or group.frame is not None:
        return
    message = "lies outside the box of `dies`, so particles would be gone at once"
    if group.layout is not None and not _within(*extent(group.layout), box):
        yield ("layout",), message
    for index, position in enumerate(group.positions or ()):
        if not _within(position, position, box):
            yield ("positions", index), message


def _emitter(scene: Scene, name: str, group: Emitter) -> Iterator[Found]:
    yield from _common(scene, group)
    has_parents = any(rule.emitter == name for parent in scene.groups.values() for rule in parent.children)
    if group.rate is None and not group.bursts and not has_parents:
        yield (), "nothing is ever born: give a `rate` or `bursts`, or name it in the `children` of another group"
    if has_parents and group.frame is not None:
        yield ("frame",), "children are born where their parents are; delete it, or let others be the children"
    yield from _rate(group, scene.duration)
    box = group.dies.outside
    if box is not None and group.frame is None:
        low, high = extent(group.shape)
        if any(high[axis] < box.min[axis] or low[axis] > box.max[axis] for axis in range(3)):
            yield (
                ("shape",),
                "lies outside the box of `dies`, so all would die at birth",
            )


def _common(scene: Scene, group: Particles | Emitter) -> Iterator[Found]:
    yield from _motion(scene, group)
    yield from _riding(scene, group)
    if has_temperature(scene, group):
        return
    if group.cooling is not None:
        yield ("cooling",), "the group has no temperature that could fall; give it a `temperature`"
    if group.dies.colder_than is not None:
        yield ("dies", "colder_than"), "the group has no temperature; give it a `temperature`"


def _riding(scene: Scene, group: Particles | Emitter) -> Iterator[Found]:
    yield from missing_frame(scene, ("frame",), group.frame)
    if group.inherit_velocity != 1.0 and (group.frame is None or group.motion != "newtonian"):
        yield ("inherit_velocity",), "is for newtonian groups with a `frame`, whose velocity they begin with"


def _motion(scene: Scene, group: Particles | Emitter) -> Iterator[Found]:
    if group.motion == "fixed":
        yield from _fixed(group)
        return
    if group.motion == "newtonian":
        if group.flow is not None:
            yield (
                ("flow",),
                "only carries groups with `motion: first_order`; others feel it through a drag force",
            )
        return
    if group.flow is None:
        yield ("motion",), "a first_order group needs a `flow` that carries it"
    else:
        yield from missing_flow(scene, ("flow",), group.flow)
    for key in OF_VELOCITY:
        field = type(group).model_fields.get(key)
        if field is not None and getattr(group, key) != field.default:
            yield (key,), "has no meaning for a first_order group, which a flow carries; delete it"


def _fixed(group: Particles | Emitter) -> Iterator[Found]:
    if isinstance(group, Emitter):
        yield ("motion",), "what is born moves: newtonian or first_order; `fixed` is for `particles`"
        return
    for key in (*OF_VELOCITY, *OF_CHANGE):
        field = type(group).model_fields.get(key)
        if field is not None and getattr(group, key) != field.default:
            yield (key,), "has no meaning for a fixed group, which rests in its frame; delete it"


def _rate(emitter: Emitter, duration: float) -> Iterator[Found]:
    until = duration if emitter.stop is None else min(emitter.stop, duration)
    if emitter.rate is None or emitter.rate.constant is not None or until < emitter.start:
        return
    times = np.linspace(emitter.start, until, SAMPLES)
    with np.errstate(all="ignore"):
        rates = np.broadcast_to(emitter.rate.evaluate({"t": times}), times.shape)
    wrong = ~np.isfinite(rates)
    if wrong.any():
        yield (
            ("rate",),
            f"is {rates[wrong][0]} at t = {times[wrong][0]:.4g} s; it must be finite all the time",
        )
    elif rates.max() <= 0:
        yield ("rate",), "is never positive while the emitter is on, so nothing would be born"


def _within(low: Vector3, high: Vector3, box: Box) -> bool:
    slack = ROUNDING * max(top - bottom for bottom, top in zip(box.min, box.max, strict=True))
    corners = zip(low, high, box.min, box.max, strict=True)
    return all(a >= bottom - slack and b <= top + slack for a, b, bottom, top in corners)


def missing_file(folder: Path, key: str, name: str) -> Iterator[Found]:
    """The problem that a key names a file that is not beside or below the scene, if it does."""
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()):
        yield (key,), "leads out of the scene's folder; put the file beside the scene"
    elif not path.is_file():
        yield (key,), f'there is no file "{name}" in the scene\'s folder'


def _quantities(path: Path) -> frozenset[str]:
    """The columns or arrays that a file has; none where it cannot be read, which its reader tells better."""
    try:
        if path.suffix.lower() == ".npz":
            with zipfile.ZipFile(path) as archive:
                return frozenset(name.removesuffix(".npy") for name in archive.namelist())
        with path.open(newline="", encoding="utf-8-sig") as file:
            return frozenset(column.strip() for column in next(csv.reader(file), []))
    except (OSError, ValueError, csv.Error, zipfile.BadZipFile):
        return frozenset()

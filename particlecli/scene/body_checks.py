"""Checks of bodies: groups with springs, drag along a body, and pins."""

from __future__ import annotations

from collections.abc import Iterator
from math import prod

from particlecli.scene.document import KeyPath
from particlecli.scene.forces import BodyDrag, CoupledForce, Springs
from particlecli.scene.group_checks import Found, missing_frame
from particlecli.scene.groups import Emitter, Particles
from particlecli.scene.model import Scene
from particlecli.scene.shapes import GridLayout, HairLayout, LatticeLayout, LinkedLayout


def body_problems(scene: Scene) -> Iterator[Found]:
    """Why groups cannot be bodies."""
    for number, force in enumerate(scene.forces):
        if isinstance(force, Springs | BodyDrag):
            for name, group in scene.groups.items():
                if group.motion == "newtonian" and force.acts_on(name):
                    yield from _body(scene, ("forces", number), force, name, group)
    for name, particles in scene.particles.items():
        for index, pin in enumerate(particles.pins):
            yield from missing_frame(scene, ("particles", name, "pins", index, "frame"), pin.frame)
        couples = any(isinstance(force, CoupledForce) and force.acts_on(name) for force in scene.forces)
        if particles.pins and not (couples and particles.motion == "newtonian"):
            yield (
                ("particles", name, "pins"),
                "hold what springs or other forces between particles pull at, and none act on this group; "
                "use `motion: fixed` for particles that just stand there",
            )
        elif particles.pins:
            yield from _mortal(scene, ("particles", name, "pins"), name, particles, "pins")


def _body(
    scene: Scene, path: KeyPath, force: Springs | BodyDrag, name: str, group: Particles | Emitter
) -> Iterator[Found]:
    if isinstance(group, Emitter):
        yield (
            (*path, "type"),
            f'"{name}" is an emitter, and {force.type} need particles that are there from the beginning; '
            "give `on` with the groups that are meant",
        )
        return
    yield from _mortal(scene, (*path, "type"), name, group, force.type)
    pairs = force.pairs if isinstance(force, Springs) else None
    if pairs is None and not isinstance(group.layout, LinkedLayout):
        yield (
            (*path, "type"),
            f'in "{name}" nothing tells which particles belong together; lay them out with `layout` of type line, grid '
            "or hair" + (", or give `pairs`" if isinstance(force, Springs) else ""),
        )
    count = _count(group)
    for index, (a, b) in enumerate(pairs or ()):
        if a == b:
            yield (*path, "pairs", index), f"joins particle {a} with itself"
        elif count is not None and max(a, b) >= count:
            yield (*path, "pairs", index), f'"{name}" has {count} particles, numbered from 0'


def _mortal(scene: Scene, path: KeyPath, name: str, group: Particles, what: str) -> Iterator[Found]:
    kills = any(plane.on_hit == "die" and (plane.on is None or name in plane.on) for plane in scene.planes)
    if group.lifetime is not None or group.dies.colder_than or group.dies.outside or kills:
        yield path, f'particles of "{name}" can die, which {what} cannot cope with; let them live'


def _count(group: Particles) -> int | None:
    match group.layout:
        case None:
            return None if group.positions is None else len(group.positions)
        case GridLayout() as grid:
            return prod(grid.counts)
        case HairLayout() as hair:
            return hair.strands * hair.count
        case LatticeLayout():
            return None
        case layout:
            return layout.count

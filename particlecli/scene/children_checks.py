"""Checks of children: that they are born into emitters, of parents that can bear, and not without end."""

from __future__ import annotations

from collections.abc import Iterator

from particlecli.scene.forces import CoupledForce
from particlecli.scene.group_checks import Found
from particlecli.scene.groups import Death, Emitter, Particles
from particlecli.scene.messages import suggestion
from particlecli.scene.model import Scene


def children_problems(scene: Scene) -> Iterator[Found]:
    """What is wrong with the children of a scene's groups."""
    for section, groups in (("particles", scene.particles), ("emitters", scene.emitters)):
        for name, group in groups.items():
            for path, message in _of_group(scene, name, group):
                yield (section, name, "children", *path), message


def _of_group(scene: Scene, name: str, group: Particles | Emitter) -> Iterator[Found]:
    if not group.children:
        return
    if any(isinstance(force, CoupledForce) and force.acts_on(name) for force in scene.forces):
        yield (), "particles that act on each other bear no children; take them out of the force with `on`"
    mortal = group.lifetime is not None or group.dies != Death() or any(plane.on_hit == "die" for plane in scene.planes)
    for number, rule in enumerate(group.children):
        if rule.emitter not in scene.emitters:
            yield (number, "emitter"), f'there is no emitter "{rule.emitter}"{suggestion(rule.emitter, scene.emitters)}'
        elif name in _descendants(scene, rule.emitter):
            way = " bears ".join(f'"{each}"' for each in _line(scene, rule.emitter, name))
            yield (number, "emitter"), f'"{name}" bears {way}: it would breed without end'
        if rule.on == "death" and not mortal:
            yield (number, "on"), "these particles never die; give the group a `lifetime`, or `dies`"
        if rule.on == "impact":
            yield from _impacts(scene, name, group, number)
        if rule.on == "way" and group.motion != "newtonian":
            yield (number, "on"), "needs newtonian parents, whose velocity tells the way between frames"


def _impacts(scene: Scene, name: str, group: Particles | Emitter, number: int) -> Iterator[Found]:
    planes = [plane for plane in scene.planes if (plane.on is None or name in plane.on) and plane.on_hit != "die"]
    if group.motion != "newtonian" or not planes:
        yield (number, "on"), "needs newtonian parents and a plane that they bounce off"
    elif scene.integrator.contact != "located" or any(plane.frame is not None for plane in planes):
        yield (number, "on"), "needs impacts located in time: planes at rest, and `integrator.contact: located`"


def _descendants(scene: Scene, name: str) -> set[str]:
    """A group and all that is born of it, of its children and so on."""
    found: set[str] = set()
    waiting = [name]
    while waiting:
        each = waiting.pop()
        if each in scene.emitters and each not in found:
            found.add(each)
            waiting += [rule.emitter for rule in scene.emitters[each].children]
    return found


def _line(scene: Scene, first: str, last: str) -> list[str]:
    """Groups from one to another, each bearing the next; there is such a line."""
    line = [first]
    while line[-1] != last:
        line.append(
            next(
                rule.emitter for rule in scene.emitters[line[-1]].children if last in _descendants(scene, rule.emitter)
            )
        )
    return line

"""What no single model can see: names that must exist, and combinations that must fit together."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePosixPath

from particlecli.errors import Problem, SceneError
from particlecli.scene.answer_checks import answer_problems
from particlecli.scene.body_checks import body_problems
from particlecli.scene.camera_checks import camera_problems
from particlecli.scene.children_checks import children_problems
from particlecli.scene.closed_forms import closed_form_problems
from particlecli.scene.coupling_checks import coupling_problems
from particlecli.scene.document import KeyPath, written
from particlecli.scene.forces import Drag, Force, PlacedForce, QuadraticDrag
from particlecli.scene.frame_checks import frame_problems
from particlecli.scene.group_checks import Found, group_problems, missing_flow, missing_frame
from particlecli.scene.integrator import SPLITTINGS
from particlecli.scene.look_checks import look_problems
from particlecli.scene.messages import suggestion
from particlecli.scene.model import Scene


def check_scene(scene: Scene) -> None:
    """Make sure that the parts of a scene fit together.

    Raises:
        SceneError: they do not; carries all problems.
    """
    found = problems(scene)
    if found:
        raise SceneError([Problem(written(path), message) for path, message in found])


def problems(scene: Scene) -> list[Found]:
    """All that is wrong between the parts of a scene: for each the path of a key, and what to do."""
    return [
        *frame_problems(scene),
        *group_problems(scene),
        *children_problems(scene),
        *_forces(scene),
        *_planes(scene),
        *_integrator(scene),
        *closed_form_problems(scene),
        *coupling_problems(scene),
        *body_problems(scene),
        *answer_problems(scene),
        *camera_problems(scene),
        *look_problems(scene),
        *_outputs(scene),
    ]


def _forces(scene: Scene) -> Iterator[Found]:
    for number, force in enumerate(scene.forces):
        yield from _acted_on(scene, ("forces", number, "on"), force.on)
        for index, name in enumerate(force.on or ()):
            motion = scene.groups[name].motion if name in scene.groups else "newtonian"
            if motion != "newtonian":
                mover = "flow" if motion == "first_order" else "frame"
                path = ("forces", number, "on", index)
                yield path, f'forces do not move "{name}", a {motion} group; its {mover} carries it'
        if isinstance(force, PlacedForce):
            yield from missing_frame(scene, ("forces", number, "frame"), force.frame)
        if isinstance(force, (Drag, QuadraticDrag)) and force.flow is not None:
            yield from missing_flow(scene, ("forces", number, "flow"), force.flow)


def _planes(scene: Scene) -> Iterator[Found]:
    for number, plane in enumerate(scene.planes):
        yield from _acted_on(scene, ("planes", number, "on"), plane.on)
        yield from missing_frame(scene, ("planes", number, "frame"), plane.frame)


def _acted_on(scene: Scene, path: KeyPath, names: tuple[str, ...] | None) -> Iterator[Found]:
    names = names or ()
    for index, name in enumerate(names):
        if name not in scene.groups:
            yield (*path, index), f'there is no group "{name}"{suggestion(name, scene.groups)}'
        elif name in names[:index]:
            yield (*path, index), f'"{name}" is named twice'


def _integrator(scene: Scene) -> Iterator[Found]:
    scheme, path = scene.integrator.type, ("integrator", "type")
    if scheme not in SPLITTINGS:
        return
    carried = [name for name, group in scene.groups.items() if group.motion == "first_order"]
    if carried:
        yield (
            path,
            f'{scheme} advances positions and velocities in turn, and "{carried[0]}", a first_order group, '
            "has no velocity; use euler, midpoint, rk3 or rk4",
        )
    spoiler = next((each for each in enumerate(scene.forces) if _spoils_splitting(scene, each[1])), None)
    if scheme != "symplectic_euler" and spoiler is not None:
        number, force = spoiler
        yield (
            path,
            f"{scheme} is of its order only where no force depends on the velocity; with the "
            f"{force.type} of forces[{number}] it would fall to first order unnoticed; use midpoint, rk3 or "
            "rk4, or symplectic_euler if first order will do",
        )


def _spoils_splitting(scene: Scene, force: Force) -> bool:
    """Whether a force depends on the velocity of any particle."""
    newtonian = {name for name, group in scene.groups.items() if group.motion == "newtonian"}
    return force.depends_on_velocity and not newtonian.isdisjoint(newtonian if force.on is None else force.on)


def _outputs(scene: Scene) -> Iterator[Found]:
    taken: dict[tuple[str, ...], int] = {}
    for number, output in enumerate(scene.outputs):
        # Compared as the least discerning file system does.
        parts = PurePosixPath(output.path.casefold()).parts
        if parts in taken:
            yield ("outputs", number, "path"), f"outputs[{taken[parts]}] goes there; give another path"
        taken.setdefault(parts, number)
    for parts, number in taken.items():
        for length in range(1, len(parts)):
            above = taken.get(parts[:length])
            if above is not None and scene.outputs[above].type != "frames":
                yield ("outputs", number, "path"), f"lies in outputs[{above}], which is a file"

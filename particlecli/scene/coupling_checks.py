"""Checks of forces between particles: what they cannot be put together with."""

from __future__ import annotations

from collections.abc import Iterator

from particlecli.scene.forces import CoupledForce
from particlecli.scene.group_checks import Found
from particlecli.scene.groups import Death, Emitter
from particlecli.scene.local_forces import Sph
from particlecli.scene.model import Scene


def coupling_problems(scene: Scene) -> Iterator[Found]:
    """Why particles that act on each other cannot be advanced."""
    for number, force in enumerate(scene.forces):
        if isinstance(force, Sph):
            yield from _moving_planes(scene, force)
            if force.density_by == "continuity":
                yield from _population(scene, number, force)
    for number, force in enumerate(scene.forces):
        if not isinstance(force, CoupledForce):
            continue
        scheme = scene.integrator.type
        if scheme == "radau_iia":
            yield (
                ("integrator", "type"),
                f"{scheme} cannot advance particles that act on each other, as the {force.type} of "
                f"forces[{number}] lets them; use tr_bdf2, implicit_euler, implicit_midpoint or trapezoidal",
            )
        for name, group in scene.groups.items():
            if group.dies.non_finite and group.motion == "newtonian" and force.acts_on(name):
                kind = "particles" if name in scene.particles else "emitters"
                yield (
                    (kind, name, "dies", "non_finite"),
                    f"a particle that is not finite spoils all that the {force.type} of forces[{number}] lets it act "
                    "on within the same step, so dropping it comes too late; leave this out",
                )
        return


def _population(scene: Scene, number: int, force: Sph) -> Iterator[Found]:
    """Density by continuity counts on what is there from the beginning."""
    for name, group in scene.groups.items():
        if not force.acts_on(name) or group.motion != "newtonian":
            continue
        kills = any(plane.on_hit == "die" and (plane.on is None or name in plane.on) for plane in scene.planes)
        if isinstance(group, Emitter) or group.lifetime is not None or group.dies != Death() or kills:
            yield (
                ("forces", number, "density_by"),
                f'continuity follows a fluid that is there from the beginning to the end, and of "{name}" particles '
                "come or go; use summation",
            )


def _moving_planes(scene: Scene, force: Sph) -> Iterator[Found]:
    for number, plane in enumerate(scene.planes):
        met = [name for name in scene.groups if plane.on is None or name in plane.on]
        if plane.frame is not None and any(force.acts_on(name) for name in met):
            yield (
                ("planes", number, "frame"),
                "a fluid of type sph has its mirror image behind planes at rest only; delete it, or say with `on` whom "
                "the plane is for",
            )

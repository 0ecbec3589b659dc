"""Checks of the known answers: whether the scene has what they are about."""

from __future__ import annotations

from collections.abc import Iterator

from particlecli.scene.group_checks import Found
from particlecli.scene.groups import Emitter, Particles
from particlecli.scene.known_answers import NAMES_OF_FLUID, NAMES_OF_VELOCITY, KnownAnswer
from particlecli.scene.local_forces import Sph
from particlecli.scene.messages import suggestion
from particlecli.scene.model import Scene


def answer_problems(scene: Scene) -> Iterator[Found]:
    """What is wrong with the known answers of a scene."""
    for number, answer in enumerate(scene.reference):
        path = ("reference", number)
        if answer.at > scene.duration:
            yield (*path, "at"), f"is after the end of the scene, which lasts {scene.duration:g} s"
        if answer.group not in scene.groups:
            message = f'there is no group "{answer.group}"{suggestion(answer.group, scene.groups)}'
            yield (*path, "group"), message
            continue
        fluid = any(isinstance(force, Sph) and force.acts_on(answer.group) for force in scene.forces)
        for name, expression in answer.expressions.items():
            if not fluid and (names := expression.names & NAMES_OF_FLUID):
                yield (*path, name), f'"{answer.group}" has no {min(names)}: no force of type sph acts on it'
        for key, message in _of_group(answer, scene.groups[answer.group]):
            yield (*path, *key), message


def _of_group(answer: KnownAnswer, group: Particles | Emitter) -> Iterator[Found]:
    if group.motion == "first_order":
        for key in _keys_of_velocity(answer):
            yield (key,), "a first_order group has no velocity; its position is all there is to know"
    count = len(group.positions) if isinstance(group, Particles) and group.positions is not None else None
    for index, particle in enumerate(answer.particles or ()):
        if particle in (answer.particles or ())[:index]:
            yield ("particles", index), f"{particle} is named twice"
        elif count is not None and particle >= count:
            yield ("particles", index), f"there are {count} particles, numbered from 0 to {count - 1}"
    named = count if answer.particles is None else len(answer.particles)
    if answer.where is not None:
        return  # How many they are, the run tells.
    for key in ("positions", "velocities"):
        given = getattr(answer, key)
        if given is not None and named is not None and len(given) != named:
            yield (key,), f"must be as many as the particles they are about: {named}, not {len(given)}"


def _keys_of_velocity(answer: KnownAnswer) -> Iterator[str]:
    for key in ("velocity", "velocities", "energy"):
        if getattr(answer, key) is not None:
            yield key
    for key, expression in answer.expressions.items():
        if expression.names & NAMES_OF_VELOCITY:
            yield key

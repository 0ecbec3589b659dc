"""Children: which particles of which groups bear others, how many there can be, and the numbers they get."""

from __future__ import annotations

import math
from collections.abc import Mapping

from particlecli.dynamics.births import EmitterBirths, ParticleBirths
from particlecli.dynamics.kin import Brood
from particlecli.scene.distributions import support
from particlecli.scene.groups import Children, Group
from particlecli.scene.model import Scene
from particlecli.scene.types import MOST

AGE_ERROR = 1e-6
"""Relative error of an age in single precision: particles may live on, and bear, that much longer."""


class Kinship:
    """All that is born of particles in a scene.

    Attributes:
        broods: the rules, those of a group before those of its children.

    Args:
        scene: whose `children` lead to no group twice over, see the checks.
        births: what is born without parents, by group.
    """

    def __init__(self, scene: Scene, births: Mapping[str, EmitterBirths | ParticleBirths]) -> None:
        self._scene, self._births = scene, births
        self._taken = {name: each.total for name, each in births.items()}
        self.broods: list[Brood] = []
        for parent in by_generation(scene):
            for rule in scene.groups[parent].children:
                self._add(parent, rule)

    def _add(self, parent: str, rule: Children) -> None:
        each = rule.count * rule.impacts if rule.count else self._most_on_the_way(parent, rule)
        total = each * self._taken[parent]
        self.broods.append(Brood(parent, rule.emitter, rule, self._taken[rule.emitter], each, total))
        self._taken[rule.emitter] += total

    def _most_on_the_way(self, parent: str, rule: Children) -> int:
        """The most that one particle can bear along its way."""
        assert rule.rate is not None
        return math.ceil(rule.rate * self._longest_life(parent) * (1 + AGE_ERROR)) + 1

    def _longest_life(self, name: str) -> float:
        lifetime = self._scene.groups[name].lifetime
        duration = self._scene.duration
        return duration if lifetime is None else min(duration, support(lifetime)[1])

    def total(self, name: str) -> int:
        """How many numbers the particles of a group have between them, children included."""
        return self._taken[name]

    def related(self, name: str) -> bool:
        """Whether particles of a group bear others or are borne by them."""
        return any(name in (brood.parent, brood.child) for brood in self.broods)

    def excess(self) -> tuple[str, int] | None:
        """A group that could have more particles than can be numbered, and how many; none if there is none."""
        return next(((name, total) for name, total in self._taken.items() if total > MOST), None)

    def most_children(self, name: str, span: float) -> int:
        """An upper bound of how many children are born into a group within any span, s."""
        return sum(self._most(brood, span) for brood in self.broods if brood.child == name)

    def _most(self, brood: Brood, span: float) -> int:
        longest = self._longest_life(brood.parent) * (1 + AGE_ERROR)
        lifetime = self._scene.groups[brood.parent].lifetime
        parents = self._most_born(brood.parent, math.inf if lifetime is None else span + longest)
        if brood.rule.rate is not None and not math.isinf(span):
            return parents * min(math.ceil(brood.rule.rate * span) + 1, brood.each)
        return parents * brood.each

    def _most_born(self, name: str, span: float) -> int:
        """An upper bound of how many particles of a group are born within any span, s."""
        births = self._births[name]
        if isinstance(births, ParticleBirths) or math.isinf(span):
            return self._taken[name]
        return min(births.largest_population(span, 0.0) + self.most_children(name, span), self._taken[name])


def by_generation(scene: Scene) -> list[str]:
    """Names of the groups, each after all that bear into it; otherwise in the order of the scene."""
    groups = scene.groups
    ordered: list[str] = []

    def visit(name: str) -> None:
        if name not in ordered:
            for parent in (each for each, group in groups.items() if name in _borne_by(group)):
                visit(parent)
            ordered.append(name)

    for name in groups:
        visit(name)
    return ordered


def _borne_by(group: Group) -> set[str]:
    return {rule.emitter for rule in group.children}

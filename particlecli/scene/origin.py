"""Where a scene was read from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

from particlecli.errors import Problem
from particlecli.scene.document import Node, unwritten


@dataclass(frozen=True)
class Origin:
    """The file a scene was read from; scenes that differ in nothing else are equal.

    Attributes:
        source: the file as the user named it; empty for a scene made in Python.
        folder: its folder, or the current one.
        document: what stands where in it.
    """

    source: str = field(default="", compare=False)
    folder: Path = field(default=Path(), compare=False)
    document: Node | None = field(default=None, compare=False, repr=False)

    def located(self, problem: Problem) -> Problem:
        """The problem with the place of its key, unless it has one or the scene was not read from a file."""
        if self.document is None or problem.line is not None or problem.option is not None:
            return problem
        place = self.document.locate(unwritten(problem.key))
        return replace(problem, line=place.line, column=place.column, option=place.option)

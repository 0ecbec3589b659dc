"""The error family: every error a user can cause or meet, each with its exit code."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar


class ParticleError(Exception):
    """Base of all errors that are reported as one clear message, without a traceback."""

    exit_code: ClassVar[int] = 1


class CheckFailedError(ParticleError):
    """A comparison against a known answer is past its tolerance."""

    exit_code = 1


class UsageError(ParticleError):
    """The command line asks for something that does not exist or does not fit together."""

    exit_code = 2


@dataclass(frozen=True)
class Problem:
    """One thing wrong with a scene: the key it is about, where that stands, what is wrong and what to do.

    `option` is the command-line option that the value came from, where it is not from the file.
    """

    key: str
    message: str
    line: int | None = None
    column: int | None = None
    option: str | None = None

    def located(self, source: str) -> str:
        """The problem as `file:line:column  key  message`, leaving out what is not known."""
        parts = (self.option,) if self.option else (source, self.line, self.column)
        place = ":".join(str(part) for part in parts if part is not None)
        return "  ".join(part for part in (place, self.key, self.message) if part)


class SceneError(ParticleError):
    """A scene that cannot be read or does not mean anything; carries every problem found at once."""

    exit_code = 2

    def __init__(self, problems: list[Problem], source: Path | str = "scene") -> None:
        self.problems = problems
        self.source = str(source)
        super().__init__("\n".join(problem.located(self.source) for problem in problems))


class SimulationError(ParticleError):
    """The simulation cannot go on: a non-finite particle, too little capacity, a rejected step."""

    exit_code = 3


class OutputError(ParticleError):
    """An output could not be written."""

    exit_code = 4

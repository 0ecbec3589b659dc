"""Jobs: which scenes run with which values, where they write, and what their results depend on."""

from __future__ import annotations

import glob
import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from particlecli.batch.sweep import Sweep, combinations
from particlecli.errors import Problem, SceneError, UsageError
from particlecli.report import versions
from particlecli.run import Quality
from particlecli.scene.load import dump_scene, load_scene
from particlecli.scene.model import Scene
from particlecli.scene.portable import portable

_UNUSUAL = re.compile(r"[^A-Za-z0-9.+=,_-]+")
_LONGEST = 100


@dataclass(frozen=True)
class Job:
    """One run.

    Attributes:
        name: of the job and of its folder.
        path: the scene file.
        scene: the scene with the job's values.
        values: what differs from the file: keys and values.
        folder: where the outputs go.
        quality: of the pictures.
        digest: of all that the result depends on: the scene, the files it reads, versions and options.
    """

    name: str
    path: Path
    scene: Scene
    values: dict[str, str]
    folder: Path
    quality: Quality
    digest: str

    @property
    def overrides(self) -> tuple[str, ...]:
        """The values as `load_scene` takes them."""
        return tuple(f"{key}={value}" for key, value in self.values.items())


def find_scenes(patterns: Sequence[str]) -> list[Path]:
    """The scene files that names and globs mean, each once.

    Raises:
        UsageError: nothing fits a name or a glob.
    """
    found: dict[Path, Path] = {}
    for pattern in patterns:
        exists = Path(pattern).exists()
        matches = [pattern] if exists else sorted(glob.glob(pattern, recursive=True))  # noqa: PTH207 - may be absolute
        paths = [Path(match) for match in matches]
        if not paths:
            raise UsageError(f"{pattern}: no such file, and no scene that fits")
        if len(paths) == 1 and paths[0].is_dir():
            raise UsageError(f"{pattern} is a folder; name the scenes in it, such as {Path(pattern) / '*.yaml'}")
        for path in paths:
            found.setdefault(path.resolve(), path)
    return list(found.values())


def make_jobs(paths: Sequence[Path], sweeps: Sequence[Sweep], folder: Path, quality: Quality) -> list[Job]:
    """Every scene with every combination of values.

    Raises:
        SceneError: scenes that are not valid with these values; all problems of all of them.
        UsageError: two jobs would write to the same folder.
    """
    jobs: list[Job] = []
    problems: list[str] = []
    for path in paths:
        for values in combinations(sweeps):
            try:
                jobs.append(_job(path, dict(values), sweeps, folder, quality))
            except SceneError as error:
                problems += [_placed(line, path) for line in str(error).splitlines()]
    if problems:
        raise SceneError([Problem("", line) for line in dict.fromkeys(problems)], "")
    _refuse_clashes(jobs)
    return jobs


def _placed(problem: str, path: Path) -> str:
    """A problem with the scene it is about, which one with a value from the command line does not name."""
    return problem if problem.startswith(str(path)) else f"{path}: {problem}"


def _job(path: Path, values: dict[str, str], sweeps: Sequence[Sweep], folder: Path, quality: Quality) -> Job:
    scene = load_scene(path, [f"{key}={value}" for key, value in values.items()])
    swept = [sweep.key for sweep in sweeps if len(sweep) > 1]
    name = _name(path.stem, {key: values[key] for key in swept})
    return Job(name, path, scene, values, folder / name, quality, _digest(scene, path.stem, quality))


def _name(stem: str, values: dict[str, str]) -> str:
    shortest = [key.rpartition(".")[2] for key in values]
    keys = shortest if len(set(shortest)) == len(shortest) else list(values)
    text = ",".join([stem, *(f"{key}={value}" for key, value in zip(keys, values.values(), strict=True))])
    name = _UNUSUAL.sub("_", text)
    return name if len(name) <= _LONGEST else f"{name[: _LONGEST - 9]}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"


def _digest(scene: Scene, name: str, quality: Quality) -> str:
    plain, attachments = portable(scene, "files")
    digest = hashlib.sha256()
    facts = {"scene": dump_scene(plain), "name": name, "quality": quality, "versions": versions()}
    digest.update(json.dumps(facts, sort_keys=True).encode())
    for attachment in attachments:
        digest.update(attachment.source.read_bytes())
    return digest.hexdigest()


def _refuse_clashes(jobs: Sequence[Job]) -> None:
    taken: dict[str, Job] = {}
    for job in jobs:
        other = taken.setdefault(job.name.casefold(), job)
        if other is not job:
            whose = " and ".join(_called(each) for each in (other, job))
            raise UsageError(f"{whose} would write to the same folder {job.folder}; rename one of the scenes")


def _called(job: Job) -> str:
    values = " ".join(f"{key}={value}" for key, value in job.values.items())
    return f"{job.path} ({values})" if values else str(job.path)

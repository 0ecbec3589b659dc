"""The manifest of a batch: what became of each job, and whether its result is still up to date."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from particlecli import __version__
from particlecli.batch.jobs import Job
from particlecli.batch.worker import Failure
from particlecli.errors import OutputError

NAME = "manifest.json"


class Manifest:
    """The entries of a batch's jobs, by name, in a file of its folder; written anew after each job.

    An entry has `scene`, `title`, `values`, `digest`, `status` ("done", "failed" or "waiting"), and `error` and
    `exit_code`, or `report`, whose files are relative to the folder.
    """

    def __init__(self, folder: Path, jobs: Sequence[Job]) -> None:
        self.path = folder / NAME
        self._folder = folder
        before = _read(self.path)
        self.entries: dict[str, dict[str, Any]] = {}
        for job in jobs:
            old = before.get(job.name, {})
            facts = {"scene": str(job.path), "title": job.scene.title, "values": job.values, "digest": job.digest}
            keeps = old.get("digest") == job.digest and old.get("status") == "done"
            self.entries[job.name] = {**facts, "status": "done", "report": old.get("report")} if keeps else {
                **facts, "status": "waiting"
            }  # fmt: skip

    def is_up_to_date(self, job: Job) -> bool:
        """Whether a job has been done with the same scene, files, versions and options, and all it wrote is there."""
        entry = self.entries[job.name]
        files = (entry.get("report") or {}).get("files", [])
        return entry["status"] == "done" and bool(files) and all((self._folder / file).exists() for file in files)

    def finish(self, job: Job, result: dict[str, Any] | Failure) -> None:
        """Notes how a job ended."""
        entry = self.entries[job.name]
        for key in ("report", "error", "exit_code"):
            entry.pop(key, None)
        if isinstance(result, Failure):
            entry |= {"status": "failed", "error": result.message, "exit_code": result.code}
        else:
            files = [Path(file).resolve().relative_to(self._folder.resolve()).as_posix() for file in result["files"]]
            entry |= {"status": "done", "report": {**result, "files": files}}
        self.write()

    def write(self) -> None:
        """Writes the file, in place of the older one.

        Raises:
            OutputError: it cannot be written.
        """
        text = json.dumps({"particlecli": __version__, "jobs": self.entries}, indent=2, ensure_ascii=False)
        replace(self.path, text + "\n")


def replace(path: Path, text: str) -> None:
    """Writes a text file that is at no time half there.

    Raises:
        OutputError: it cannot be written.
    """
    temporary = path.with_name(f".{path.name}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(path)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from None


def _read(path: Path) -> dict[str, Any]:
    """The entries of an older manifest; none where there is none that can be read."""
    try:
        jobs = json.loads(path.read_text(encoding="utf-8"))["jobs"]
    except (OSError, ValueError, KeyError, TypeError):
        return {}
    return jobs if isinstance(jobs, dict) else {}

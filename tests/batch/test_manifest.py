from __future__ import annotations

import json
from pathlib import Path

import pytest

from particlecli.batch.jobs import Job
from particlecli.batch.manifest import Manifest
from particlecli.batch.worker import Failure
from particlecli.errors import OutputError
from tests.batch.conftest import MakeJobs, report


def finished(job: Job, folder: Path) -> Manifest:
    job.folder.mkdir(parents=True)
    (job.folder / "balls.npz").touch()
    manifest = Manifest(folder, [job])
    manifest.finish(job, report(str(job.folder / "balls.npz")))
    return manifest


def test_a_job_is_up_to_date_until_it_changes_or_its_files_are_gone(jobs: MakeJobs, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    (job,) = jobs()
    assert not Manifest(folder, [job]).is_up_to_date(job)
    finished(job, folder)
    assert Manifest(folder, [job]).is_up_to_date(job)
    (changed,) = jobs("seed=4")
    assert not Manifest(folder, [changed]).is_up_to_date(changed)
    (job.folder / "balls.npz").unlink()
    assert not Manifest(folder, [job]).is_up_to_date(job)


def test_files_are_relative_to_the_folder(jobs: MakeJobs, tmp_path: Path) -> None:
    finished(jobs()[0], tmp_path / "out")
    entry = json.loads((tmp_path / "out" / "manifest.json").read_text())["jobs"]["balls"]
    assert entry["report"]["files"] == ["balls/balls.npz"]
    assert entry["status"] == "done"


def test_a_failed_job_is_not_up_to_date(jobs: MakeJobs, tmp_path: Path) -> None:
    (job,) = jobs()
    manifest = finished(job, tmp_path / "out")
    manifest.finish(job, Failure("not finite", 3))
    entry = json.loads(manifest.path.read_text())["jobs"]["balls"]
    assert (entry["status"], entry["error"], entry["exit_code"]) == ("failed", "not finite", 3)
    assert "report" not in entry
    assert not Manifest(tmp_path / "out", [job]).is_up_to_date(job)


@pytest.mark.parametrize("content", ["", "[]", '{"jobs": 3}', "not json", '{"jobs": {"balls": {}}}'])
def test_a_broken_manifest_means_that_nothing_is_up_to_date(jobs: MakeJobs, tmp_path: Path, content: str) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "manifest.json").write_text(content)
    (job,) = jobs()
    assert not Manifest(tmp_path / "out", [job]).is_up_to_date(job)


def test_folder_that_cannot_be_written(jobs: MakeJobs, tmp_path: Path) -> None:
    (tmp_path / "out").touch()
    with pytest.raises(OutputError, match="cannot write"):
        Manifest(tmp_path / "out", jobs()).write()

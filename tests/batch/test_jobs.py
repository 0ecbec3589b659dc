from __future__ import annotations

from pathlib import Path

import pytest

from particlecli.batch.jobs import find_scenes, make_jobs
from particlecli.batch.sweep import parse_sweep
from particlecli.errors import SceneError, UsageError
from tests.batch.conftest import SCENE, MakeJobs


def test_jobs_are_named_after_what_is_swept(jobs: MakeJobs, tmp_path: Path) -> None:
    made = jobs("integrator.dt=0.05,0.025", "forces.1.coefficient=0", "forces.0.acceleration=[0, -1, 0],[0, -2, 0]")
    assert [job.name for job in made[:2]] == [
        "balls,dt=0.05,acceleration=_0,_-1,_0_",
        "balls,dt=0.05,acceleration=_0,_-2,_0_",
    ]
    assert made[0].folder == tmp_path / "out" / made[0].name
    assert made[3].scene.integrator.dt == 0.025
    assert made[3].scene.forces[1].coefficient == 0
    assert made[3].overrides[1] == "forces.1.coefficient=0"


def test_keys_that_end_alike_are_named_in_full(jobs: MakeJobs, scene: Path) -> None:
    scene.write_text(SCENE.replace("{type: gravity}", "{type: quadratic_drag, coefficient: 3}"))
    assert jobs("forces.0.coefficient=1,2", "forces.1.coefficient=1,2")[0].name == (
        "balls,forces.0.coefficient=1,forces.1.coefficient=1"
    )


def test_long_names_are_cut_and_still_differ(jobs: MakeJobs) -> None:
    long = ",".join(f"'{'title ' * 40}{number}'" for number in range(2))
    first, second = jobs(f"title={long}")
    assert len(first.name) <= 100
    assert first.name != second.name


def test_digest_follows_all_that_a_result_depends_on(jobs: MakeJobs, scene: Path, tmp_path: Path) -> None:
    (job,) = jobs()
    assert jobs()[0].digest == job.digest
    assert jobs("seed=1")[0].digest != job.digest
    assert make_jobs([scene], [], tmp_path / "out", "draft")[0].digest != job.digest
    scene.write_text("# a remark changes nothing\n" + SCENE)
    assert jobs()[0].digest == job.digest
    scene.write_text(SCENE.replace("positions: [[0, 1, 0]]", "file: balls.csv"))
    digests = []
    for height in (1, 2):
        (tmp_path / "balls.csv").write_text(f"x,y,z\n0,{height},0\n")
        digests.append(jobs()[0].digest)
    assert len({job.digest, *digests}) == 3


def test_unknown_keys_are_refused_with_the_scene_they_are_unknown_to(scene: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.yaml"
    other.write_text(SCENE.replace("forces: [{type: gravity}, {type: drag, coefficient: 1}]\n", ""))
    with pytest.raises(SceneError) as caught:
        make_jobs([scene, other], [parse_sweep("forces.1.coefficient=1,2")], tmp_path / "out", "final")
    (line,) = str(caught.value).splitlines()
    assert line.startswith(f"{other}: --set forces.1.coefficient")
    with pytest.raises(SceneError, match='did you mean "dt"'):
        make_jobs([scene], [parse_sweep("integrator.dtt=1,2")], tmp_path / "out", "final")


def test_two_jobs_with_the_same_output(scene: Path, tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    other = tmp_path / "sub" / "Balls.yaml"
    other.write_text(SCENE)
    with pytest.raises(UsageError, match=r"balls\.yaml and .*Balls\.yaml would write to the same folder"):
        make_jobs([scene, other], [], tmp_path / "out", "final")


def test_scenes_are_found_by_name_and_glob_each_once(scene: Path, tmp_path: Path) -> None:
    (tmp_path / "z.yaml").write_text(SCENE)
    assert find_scenes([str(tmp_path / "z.yaml"), str(tmp_path / "*.yaml")]) == [tmp_path / "z.yaml", scene]
    for pattern, says in ((str(tmp_path / "*.yml"), "no scene that fits"), (str(tmp_path), "is a folder")):
        with pytest.raises(UsageError, match=says):
            find_scenes([pattern])

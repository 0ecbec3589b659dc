"""Batches from the command line: what succeeds, what fails, and what is not run again."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from particlecli.cli.gallery import shipped_scenes
from tests.cli.conftest import SCENE, Cli, imported_by

TABLE = "outputs: [{type: trajectory, path: balls.npz}]\n"


def test_a_failing_scene_does_not_stop_the_others_and_what_is_done_is_not_done_again(
    cli: Cli, scene: Path, tmp_path: Path
) -> None:
    scene.write_text(SCENE + TABLE)
    field = '{type: force_field, force: ["1e38*x*x", 0, 0]}'
    bad = SCENE.replace("{type: gravity}", field).replace("[0, 1, 0]", "[1, 1, 0]")
    (tmp_path / "bad.yaml").write_text(bad + TABLE)
    result = cli("batch", "b*.yaml", "--set", "seed=1,2", "-o", "out", "--jobs", "2")
    assert result.returncode == 1
    assert result.stdout.startswith("2 done, 0 up to date, 2 failed\n")
    assert "failed: bad,seed=2: group balls, particle 0: not finite" in result.stderr.splitlines()[-1]
    entries = json.loads((tmp_path / "out" / "manifest.json").read_text())["jobs"]
    assert {name: entry["status"] for name, entry in entries.items()} == {
        "bad,seed=1": "failed", "bad,seed=2": "failed", "balls,seed=1": "done", "balls,seed=2": "done",
    }  # fmt: skip
    assert (tmp_path / "out" / "balls,seed=1" / "balls.npz").exists()
    assert "2 failed" in (tmp_path / "out" / "index.html").read_text()

    again = cli("batch", "balls.yaml", "--set", "seed=1,2", "-o", "out", "--json")
    assert again.returncode == 0
    outcome = json.loads(again.stdout)
    assert (outcome["done"], outcome["skipped"]) == ([], ["balls,seed=1", "balls,seed=2"])
    forced = cli("batch", "balls.yaml", "--set", "seed=1", "-o", "out", "--force", "--quiet")
    assert (forced.returncode, forced.stderr) == (0, "")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["balls.yaml", "--set", "integrator.dtt=1,2"], 'did you mean "dt"?'),
        (["balls.yaml", "--set", "forces.4.acceleration=[0,0,0],[0,1,0]"], "1 entries"),
        (["balls.yaml", "sub/balls.yaml"], "same folder"),
        (["no*.yaml"], "no scene that fits"),
        (["balls.yaml", "--jobs", "0"], "--jobs"),
    ],
)
def test_refused_before_anything_starts(cli: Cli, scene: Path, tmp_path: Path, arguments: list[str], says: str) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "balls.yaml").write_text(SCENE)
    result = cli("batch", *arguments, "-o", "out")
    assert result.returncode == 2
    assert says in result.stderr
    assert not (tmp_path / "out").exists()


def test_the_gallery_has_the_shipped_scenes() -> None:
    assert {"campfire", "fountain", "snow"} <= {path.stem for path in shipped_scenes()}


def test_taichi_stays_out_of_the_process_that_waits() -> None:
    modules = imported_by("import particlecli.batch.batch, particlecli.cli.batch_progress")
    assert not modules & {"taichi", "rerun"}

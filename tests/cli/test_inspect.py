"""Recordings made, inspected, compared and run again from the command line."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from particlecli.cli.sparkline import sparkline
from tests.cli.conftest import SCENE, Cli, imported_by


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with balls.rrd, and others.rrd of a run with a smaller step."""
    folder = tmp_path_factory.mktemp("recordings")
    (folder / "balls.yaml").write_text(SCENE + "planes: [{}]\n")
    for name, dt in (("balls", 0.05), ("others", 0.025)):
        command = ["run", "balls.yaml", "-o", ".", "--rrd", f"{name}.rrd", "--quiet", "--set", f"integrator.dt={dt}"]
        subprocess.run([sys.executable, "-m", "particlecli", *command], cwd=folder, check=True, capture_output=True)
    return folder


def test_summary_tells_what_is_inside(cli: Cli, recordings: Path) -> None:
    result = cli("inspect", recordings / "balls.rrd")
    assert (result.returncode, result.stderr) == (0, "")
    assert "Three balls" in result.stdout
    assert "frame 0 … 2 (3 recorded), sim_time 0 … 0.2 s" in result.stdout
    assert "3 … 3" in result.stdout
    assert "energy/kinetic" in result.stdout
    assert "▁" not in result.stdout
    assert "report  3 frames, 3 particles" in result.stdout


def test_summary_as_json(cli: Cli, recordings: Path) -> None:
    facts = json.loads(cli("inspect", recordings / "balls.rrd", "--json").stdout)
    assert facts["timelines"] == {"frame": [0, 2], "sim_time": [0, 0.2]}
    assert facts["groups"]["balls"]["points"] == 9
    low, high = facts["groups"]["balls"]["low"], facts["groups"]["balls"]["high"]
    assert (low[0], high) == (0, [0, 3, 0])
    assert 0.7 < low[1] < 0.9
    assert facts["series"]["alive/balls"] == {"count": 3, "first": 3, "last": 3, "least": 3, "most": 3}
    # Symplectic Euler with half the step loses half as much, so this is far from a tolerance of zero.
    assert facts["series"]["energy/total"]["first"] == pytest.approx(6 * 9.80665, rel=1e-3)
    error = facts["series"]["error/balls"]
    assert (error["count"], 0 < error["first"] < error["last"]) == (2, True)
    assert facts["report"]["births"] == {"balls": 3}


def test_particles_of_a_frame_are_printed_and_exported(cli: Cli, recordings: Path, tmp_path: Path) -> None:
    printed = cli("inspect", recordings / "balls.rrd", "--time", "0.04").stdout
    assert printed.startswith("frame 0, 0 s\n\nballs: 3 particles\n")
    for ending in ("csv", "npz"):
        assert cli("inspect", recordings / "balls.rrd", "--frame", "2", "--export", f"a.{ending}").returncode == 0
    with (tmp_path / "a.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    with np.load(tmp_path / "a.npz") as table:
        assert [float(row["y"]) for row in rows] == pytest.approx(table["position"][:, 1].tolist(), rel=1e-6)
        assert [int(row["id"]) for row in rows] == table["id"].tolist() == [0, 1, 2]


def test_diff_says_where_recordings_part(cli: Cli, recordings: Path) -> None:
    same = cli("inspect", recordings / "balls.rrd", "--diff", recordings / "balls.rrd")
    assert (same.returncode, "agree" in same.stdout) == (0, True)
    result = cli("inspect", recordings / "balls.rrd", "--diff", recordings / "others.rrd")
    assert result.returncode == 1
    assert result.stdout.startswith("balls at frame 1 (0.1 s): particle ")
    changes = [line for line in result.stdout.splitlines() if line.startswith(("  -", "  +"))]
    assert [change.split() for change in changes] == [["-", "dt:", "0.05"], ["+", "dt:", "0.025"]]
    tolerant = cli("inspect", recordings / "balls.rrd", "--diff", recordings / "others.rrd", "--tolerance", "0.1")
    assert (tolerant.returncode, "agree; no particle is more than" in tolerant.stdout) == (0, True)


def test_extracted_scene_runs_again_to_the_same_recording(cli: Cli, recordings: Path, tmp_path: Path) -> None:
    assert cli("inspect", recordings / "others.rrd", "--extract-scene", "again/scene.yaml").returncode == 0
    assert cli("run", "again/scene.yaml", "-o", "out", "--quiet").returncode == 0
    assert cli("inspect", "out/others.rrd", "--diff", recordings / "others.rrd").returncode == 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--frame", "7"], "the last frame is 2"),
        (["--time", "9"], "ends at 0.2 s"),
        (["--frame", "1", "--time", "0"], "one at a time"),
        (["--export", "a.csv"], "--export needs"),
        (["--frame", "1", "--export", "a.txt"], ".csv or .npz"),
        (["--diff", "nothing.rrd"], "nothing.rrd: no such file"),
        (["--frame", "-1"], "--frame"),
    ],
)
def test_questions_that_make_no_sense(cli: Cli, recordings: Path, arguments: list[str], says: str) -> None:
    result = cli("inspect", recordings / "balls.rrd", *arguments)
    assert result.returncode == 2
    assert says in result.stderr
    assert "Traceback" not in result.stderr


def test_what_is_no_recording(cli: Cli, scene: Path) -> None:
    for command in ("inspect", "view"):
        result = cli(command, scene)
        assert (result.returncode, result.stderr) == (2, f"{scene} is not a Rerun recording\n")


def test_export_that_cannot_be_written(cli: Cli, recordings: Path) -> None:
    result = cli("inspect", recordings / "balls.rrd", "--frame", "1", "--export", "no/such/folder/a.csv")
    assert result.returncode == 4
    assert "cannot write" in result.stderr


def test_viewer_needs_a_screen(cli: Cli, recordings: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    if sys.platform.startswith("linux"):
        result = cli("view", recordings / "balls.rrd")
        assert (result.returncode, "--web" in result.stderr) == (2, True)


def test_viewer_tells_of_a_recording_that_is_cut_short(
    cli: Cli, recordings: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "half.rrd"
    path.write_bytes((recordings / "balls.rrd").read_bytes()[:-1000])
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    if sys.platform.startswith("linux"):
        result = cli("view", path)
        assert result.returncode == 2
        assert result.stderr.startswith(f"{path} is cut short, and there is no screen")
        assert result.stderr.count("\n") == 1


def test_rerun_is_not_imported_until_it_is_needed() -> None:
    modules = imported_by("import particlecli.run, particlecli.cli.app")
    assert not modules & {"rerun", "pyarrow"}


def test_sparkline() -> None:
    assert sparkline([0, 1, 2, 3, 4, 5, 6, 7], 8) == "▁▂▃▄▅▆▇█"
    assert sparkline([0, 0, 7, 7], 2) == "▁█"
    assert sparkline([5.0, 5.0], 40) == "▁▁"
    assert sparkline([0, float("nan"), -1e308, 1e308], 4) == "▅ ▁█"
    assert sparkline([], 4) == ""

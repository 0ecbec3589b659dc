from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.cli.conftest import Cli


def test_flags_choose_what_is_written_and_where(cli: Cli, scene: Path, tmp_path: Path) -> None:
    result = cli("run", "balls.yaml", "-o", "out", "--trajectory", "a.csv", "--quiet")
    assert result.returncode == 0
    assert result.stderr == ""
    files = {"a.csv", "balls.scene.yaml", "balls.report.json"}
    assert {path.name for path in (tmp_path / "out").iterdir()} == files
    assert all(f"wrote {Path('out') / name}" in result.stdout for name in files)


def test_json_is_the_report_that_is_written(cli: Cli, scene: Path, tmp_path: Path) -> None:
    result = cli("run", "balls.yaml", "--trajectory", "a.npz", "--json")
    report = json.loads(result.stdout)
    assert report == json.loads((tmp_path / "outputs" / "balls" / "balls.report.json").read_text())
    phases = ("choose", "compile", "simulate", "estimate", "render", "encode", "wall")
    assert set(report["phases"]) == {f"{phase}_s" for phase in phases}
    error = report["estimated_error"]["balls"]
    assert error["metres"]["p95"] == pytest.approx(9.81 * 0.2 * 0.05 / 2, rel=0.01)  # of the first-order scheme
    assert error["trend"] == "converging"
    assert report["births"] == {"balls": 3}
    assert report["conserved"] == {}
    assert report["particle_steps"] == 3 * 4


def test_time_for_choosing_is_told_where_auto_chooses(cli: Cli, scene: Path) -> None:
    chosen = cli("run", "balls.yaml", "--set", "integrator={type: auto}", "--no-output").stdout
    assert "chosen by auto" in chosen
    assert " s: choose " in chosen
    assert " s: compile " in cli("run", "balls.yaml", "--no-output").stdout


def test_no_output_writes_nothing(cli: Cli, scene: Path, tmp_path: Path) -> None:
    result = cli("run", "balls.yaml", "--no-output", "--json")
    assert result.returncode == 0
    assert json.loads(result.stdout)["files"] == []
    assert list(tmp_path.iterdir()) == [scene]


def test_estimates_are_left_out_when_asked(cli: Cli, scene: Path) -> None:
    result = cli("run", "balls.yaml", "--no-output", "--no-estimate", "--json")
    report = json.loads(result.stdout)
    assert (report["estimated_error"], report["not_estimated"], report["conserved"]) == ({}, [], {})


def test_a_long_run_without_output_tells_how_to_get_an_estimate(cli: Cli, scene: Path) -> None:
    long = ("run", "balls.yaml", "--no-output", "--quiet", "--set", "integrator.dt=2e-7")
    told = cli(*long).stdout
    assert "error not estimated: balls: more than 5 % of this run; --estimate does it at any cost" in told
    forced = cli(*long, "--estimate").stdout
    assert "not estimated" not in forced
    assert "error: estimated from a sample" in forced


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--no-output", "--video", "a.mp4"], "contradict"),
        (["--video", "../a.mp4"], "-o chooses the output folder"),
        (["--video", "a.avi"], ".mp4"),
        (["--trajectory", "a.txt"], ".npz"),
        (["--frames", ""], "--frames"),
        (["--frames", "a.npz", "--trajectory", "a.npz"], "two outputs"),
        (["--quality", "best"], "draft"),
        (["--threads", "0"], "--threads"),
        (["--set", "duration"], "key=value"),
    ],
)
def test_arguments_that_make_no_sense(cli: Cli, scene: Path, tmp_path: Path, arguments: list[str], says: str) -> None:
    result = cli("run", "balls.yaml", *arguments)
    assert result.returncode == 2
    assert says in result.stderr
    assert "Traceback" not in result.stderr
    assert list(tmp_path.iterdir()) == [scene]


def test_unwritable_folder_exits_with_4_before_anything_is_simulated(cli: Cli, scene: Path, tmp_path: Path) -> None:
    (tmp_path / "out").touch()
    result = cli("run", "balls.yaml", "-o", "out", "--trajectory", "a.npz", "--set", "duration=1e9")
    assert result.returncode == 4
    assert "cannot write" in result.stderr


def test_failed_simulation_exits_with_3_and_leaves_nothing(cli: Cli, scene: Path, tmp_path: Path) -> None:
    field = '{type: force_field, force: ["1e38*x*x", 0, 0]}'
    scene.write_text(scene.read_text().replace("{type: gravity}", field).replace("[0, 1, 0]", "[1, 1, 0]"))
    result = cli("run", "balls.yaml", "-o", "out", "--trajectory", "a.npz")
    assert result.returncode == 3
    assert "balls" in result.stderr
    assert list(tmp_path.iterdir()) == [scene]


def heeds_interrupts() -> None:
    """Where tests run in the background of a script, processes are told to ignore interrupts."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.mark.parametrize(("sent", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_stopped_run_leaves_nothing(scene: Path, tmp_path: Path, sent: signal.Signals, code: int) -> None:
    arguments = ["run", "balls.yaml", "-o", "out", "--trajectory", "a.npz", "--set", "duration=1e7"]
    process = subprocess.Popen(
        [sys.executable, "-m", "particlecli", *arguments],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heeds_interrupts,
    )
    while process.poll() is None and not list(tmp_path.glob("out/.balls*")):
        time.sleep(0.05)
    time.sleep(2)
    process.send_signal(sent)
    _, messages = process.communicate(timeout=60)
    assert process.returncode == code
    assert "Traceback" not in messages
    assert list(tmp_path.iterdir()) == [scene]

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.conftest import Cli


def test_table_data_and_plots(cli: Cli, scene: Path, tmp_path: Path) -> None:
    scene.write_text(scene.read_text() + "precision: double\n")
    result = cli("bench", "balls.yaml", "-o", "out", "--integrators", "euler,midpoint", "--steps", "1,2", "--no-peers")
    assert result.returncode == 0, result.stderr
    assert "euler, double precision" in result.stderr
    for text in ("euler, double", "midpoint, double", "0.05 s", "★", "no peers: not asked for"):
        assert text in result.stdout
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"bench.json", "bench.svg", "bench.png"}
    assert (tmp_path / "out" / "bench.svg").read_text(encoding="utf-8").startswith("<?xml")
    data = json.loads((tmp_path / "out" / "bench.json").read_text())
    errors = {
        (run["integrator"], run["steps_per_frame"]): run["error"]["metres"]["final_frame"]["largest"]
        for run in data["runs"]
    }
    for steps in (1, 2):  # of the first order g t dt / 2, none of the second
        assert errors["euler", steps] == pytest.approx(9.80665 * 0.2 * 0.1 / steps / 2, rel=1e-9)
        assert errors["midpoint", steps] < 1e-12


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--integrators", "rk5"], 'there is no "rk5"'),
        (["--steps", "0"], "--steps takes positive whole numbers"),
        (["--tolerances", "1e-3,x"], "--tolerances takes positive numbers"),
        (["--set", "duration=0.01"], "ends before its second frame"),
    ],
)
def test_what_cannot_be_measured_is_a_usage_error(cli: Cli, scene: Path, arguments: list[str], says: str) -> None:
    result = cli("bench", "balls.yaml", "--quiet", *arguments)
    assert result.returncode == 2
    assert says in result.stderr
    assert "Traceback" not in result.stderr

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.conftest import Cli

STIFF = """\
title: Pellets
duration: 0.2
fps: 10
particles: {pellets: {positions: [[0, 1, 0]], velocities: [[1, 0, 0]]}}
forces: [{type: drag, coefficient: 10000}]
integrator: {type: rk4, dt: 0.1}
"""


@pytest.fixture
def stiff(tmp_path: Path) -> Path:
    path = tmp_path / "stiff.yaml"
    path.write_text(STIFF)
    return path


def test_modes_limits_and_a_sentence(cli: Cli, stiff: Path) -> None:
    result = cli("analyze", "stiff.yaml", "--plot", "regions.png")
    assert result.returncode == 0, result.stderr
    assert "decay   50 %   1e+04 1/s" in result.stdout
    assert "rk4 (the scene's)  0.000279 s" in result.stdout
    assert "That is stiff" in result.stdout
    assert (stiff.parent / "regions.png").read_bytes().startswith(b"\x89PNG")


def test_json_is_one_object(cli: Cli, stiff: Path) -> None:
    facts = json.loads(cli("analyze", "stiff.yaml", "--json").stdout)
    assert facts["stable_up_to"]["rk4"]["step_s"] == pytest.approx(2.785293563405e-4)
    assert facts["stable_up_to"]["radau_iia"]["step_s"] is None
    assert facts["groups"][0]["modes"]["decay"]["to"] == pytest.approx(1e4)


def test_usage_errors(cli: Cli, stiff: Path) -> None:
    assert cli("analyze", "stiff.yaml", "--plot", "regions.txt").returncode == 2
    assert cli("analyze", "stiff.yaml", "--at", "9").returncode == 2


def test_run_refuses_the_step_with_exit_code_3(cli: Cli, stiff: Path) -> None:
    result = cli("run", "stiff.yaml", "--no-output", "--quiet")
    assert result.returncode == 3
    assert "rk4 is unstable at steps of 0.1 s" in result.stderr
    assert cli("run", "stiff.yaml", "--no-output", "--quiet", "--set", "integrator.type=exact").returncode == 0

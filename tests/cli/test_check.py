from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.conftest import Cli

KNOWN = """\
reference:
  - {at: 0.2, group: balls, particles: [1], position: [0, 1.803867, 0], tolerance: TOLERANCE, source: by hand}
"""


@pytest.fixture
def known(scene: Path) -> Path:
    """The scene with a known answer that rk4 meets to 1e-6 m."""
    text = scene.read_text().replace("symplectic_euler", "rk4")
    scene.write_text(text + KNOWN.replace("TOLERANCE", "1e-5"))
    return scene


def test_errors_are_told_beside_what_is_known(process: Cli, known: Path) -> None:
    result = process("check", "balls.yaml")
    assert result.returncode == 0, result.stderr
    assert "balls.yaml  Three balls" in result.stdout
    assert "balls 1: position at 0.2 s" in result.stdout
    assert "1e-05 m" in result.stdout
    assert " ok" in result.stdout


def test_a_lower_order_is_past_the_tolerance(cli: Cli, known: Path) -> None:
    result = cli("check", "balls.yaml", "--set", "integrator.type=euler")
    assert result.returncode == 1
    assert "FAILED" in result.stdout
    assert "1 of 1 comparisons are past their tolerance" in result.stderr


def test_a_scene_of_which_nothing_is_known(cli: Cli, scene: Path) -> None:
    result = cli("check", "balls.yaml")
    assert result.returncode == 2
    assert "--against scipy" in result.stderr


def test_json_is_one_object_also_when_it_fails(cli: Cli, known: Path) -> None:
    result = cli("check", "balls.yaml", "--json", "--set", "integrator.type=euler")
    assert result.returncode == 1
    facts = json.loads(result.stdout)
    (checked,) = facts["scenes"]
    (comparison,) = checked["known"]
    assert facts["passed"] is checked["passed"] is comparison["passed"] is False
    assert comparison["source"] == "by hand"
    assert comparison["error"] > comparison["tolerance"] == 1e-5


def test_scipy_judges_scenes_without_known_answers(cli: Cli, scene: Path) -> None:
    result = cli("check", "balls.yaml", "--against", "scipy", "--tolerance", "1 m", "--json")
    assert result.returncode == 0, result.stderr
    (judged,) = json.loads(result.stdout)["scenes"][0]["against_scipy"]
    assert 0 < judged["largest"]["metres"] < 1
    strict = cli("check", "balls.yaml", "--against", "scipy", "--tolerance", "1e-9 m")
    assert strict.returncode == 1
    assert "position at worst" in strict.stdout


def test_what_cannot_be_judged_exits_with_2_and_the_reason(cli: Cli, scene: Path) -> None:
    result = cli("check", "balls.yaml", "--against", "scipy", "--set", "duration=1e7")
    assert result.returncode == 2
    assert "too many for SciPy" in result.stderr


def test_particles_out_of_the_picture_have_no_pixels(cli: Cli, scene: Path) -> None:
    result = cli("check", "balls.yaml", "--against", "scipy", "--set", "camera.look_at=[0, 1, 20]")
    assert result.returncode == 2
    assert "--tolerance in metres" in result.stderr


@pytest.mark.parametrize("tolerance", ["0 m", "-1 px", "1 km", "much", "nan m"])
def test_tolerances_that_make_no_sense(cli: Cli, scene: Path, tolerance: str) -> None:
    result = cli("check", "balls.yaml", f"--tolerance={tolerance}")
    assert result.returncode == 2
    assert "0.5 px" in result.stderr


def test_a_bad_scene_does_not_keep_others_from_being_checked(cli: Cli, known: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.yaml").write_text("duration: -1\n")
    result = cli("check", "bad.yaml", "balls.yaml")
    assert result.returncode == 2
    assert "bad.yaml" in result.stderr
    assert "balls 1: position" in result.stdout

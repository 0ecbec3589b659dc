from __future__ import annotations

from pathlib import Path

from tests.cli.conftest import Cli, imported_by


def test_valid_scene(process: Cli, scene: Path) -> None:
    result = process("validate", "balls.yaml")
    assert (result.returncode, result.stdout, result.stderr) == (0, "balls.yaml: valid\n", "")


def test_every_problem_of_every_scene_is_told_with_its_place(cli: Cli, scene: Path) -> None:
    wrong = scene.read_text().replace("integrator:", "integrater:").replace("duration: 0.2", "duration: -1")
    (scene.parent / "wrong.yaml").write_text(wrong)
    result = cli("validate", "wrong.yaml", "missing.yaml", "balls.yaml")
    assert result.returncode == 2
    assert result.stdout == "balls.yaml: valid\n"
    problems = result.stderr.splitlines()
    assert problems[0].startswith("wrong.yaml:2:")
    assert problems[1].startswith("wrong.yaml:8:")
    assert "integrator" in problems[1]
    assert problems[2].startswith("missing.yaml: no such file")
    assert len(problems) == 3


def test_overrides_are_checked(cli: Cli, scene: Path) -> None:
    assert cli("validate", "balls.yaml", "--set", "duration=3").returncode == 0
    result = cli("validate", "balls.yaml", "--set", "duration=-3")
    assert result.returncode == 2
    assert "duration" in result.stderr


def test_taichi_stays_unloaded(scene: Path) -> None:
    modules = imported_by(f"from particlecli.cli import validate\nvalidate.command([Path({str(scene)!r})])")
    assert "particlecli.scene.load" in modules
    assert not modules & {"taichi", "rerun", "imageio_ffmpeg", "matplotlib"}

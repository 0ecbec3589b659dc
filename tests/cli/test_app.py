from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import particlecli
from tests.cli.conftest import Cli, imported_by


def test_help_names_every_command(cli: Cli) -> None:
    result = cli("--help")
    assert result.returncode == 0
    for command in ("run", "validate", "explain", "new", "schema"):
        assert f"\n  {command} " in result.stdout


def test_version(cli: Cli) -> None:
    result = cli("--version")
    assert (result.returncode, result.stdout) == (0, f"particlecli {particlecli.__version__}\n")


@pytest.mark.parametrize(
    ("arguments", "hint"), [(["rnu", "a.yaml"], "'run'"), (["run", "--vidoe", "a.mp4"], "--video")]
)
def test_mistyped_words_suggest_the_nearest(cli: Cli, arguments: list[str], hint: str) -> None:
    result = cli(*arguments)
    assert result.returncode == 2
    assert hint in result.stderr
    assert result.stdout == ""


@pytest.mark.parametrize("arguments", [[], ["run"], ["run", "a.yaml", "b.yaml"], ["new"]])
def test_usage_errors_exit_with_2(cli: Cli, arguments: list[str]) -> None:
    assert cli(*arguments).returncode == 2


def test_missing_scene_suggests_one_that_is_called_alike(cli: Cli, scene: Path) -> None:
    result = cli("run", "bals.yaml")
    assert result.returncode == 2
    assert result.stderr == "bals.yaml: no such file; did you mean balls.yaml?\n"


def test_missing_scene_is_also_looked_for_among_the_scenes(cli: Cli, scene: Path) -> None:
    (scene.parent / "scenes").mkdir()
    scene.rename(scene.parent / "scenes" / "balls.yaml")
    assert f"did you mean {Path('scenes/balls.yaml')}?" in cli("run", "balls.yaml").stderr


def test_completion_can_be_shown() -> None:
    environment = os.environ | {"_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    command = [sys.executable, "-m", "particlecli", "--show-completion", "bash"]
    result = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert "_PARTICLECLI_COMPLETE" in result.stdout


def test_completion_knows_the_commands() -> None:
    environment = os.environ | {
        "_PARTICLECLI_COMPLETE": "complete_bash",
        "COMP_WORDS": "particlecli va",
        "COMP_CWORD": "1",
    }
    command = [sys.executable, "-m", "particlecli"]
    result = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert result.stdout.split() == ["validate"]


def test_importing_the_package_is_light() -> None:
    modules = imported_by("import particlecli")
    assert "particlecli" in modules
    assert not modules & {"taichi", "numpy", "pydantic", "yaml", "typer"}


def test_help_imports_nothing_heavy() -> None:
    modules = imported_by("import particlecli.cli.app")
    assert not modules & {"taichi", "numpy", "pydantic", "yaml", "rich", "imageio", "imageio_ffmpeg", "rerun"}


def test_public_names_are_there_and_are_the_functions() -> None:
    code = "import particlecli.run, particlecli.simulate as _\nfrom particlecli import *\n"
    imported_by(code + "assert all(map(callable, (run, simulate, load_scene, Frame, RunOptions)))")


def test_unknown_public_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'fly'"):
        _ = particlecli.fly


def test_closed_pipe_is_silent(scene: Path) -> None:
    command = f"{sys.executable} -m particlecli explain {scene} | true"
    result = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert result.stderr == ""


def test_bugs_ask_for_a_report_and_show_the_traceback_when_told_to() -> None:
    code = "import sys\nfrom particlecli.cli import app, validate\nvalidate.load = lambda *_: 1 / 0\n"
    command = [sys.executable, "-c", code + "sys.argv = ['particlecli', 'validate', 'a.yaml']\napp.main()"]
    for debug, traceback in (("", False), ("1", True)):
        environment = os.environ | {"PARTICLECLI_DEBUG": debug}
        result = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        assert result.returncode == 70
        assert "ZeroDivisionError: division by zero" in result.stderr
        assert "report" in result.stderr
        assert ("Traceback" in result.stderr) == traceback

from __future__ import annotations

from pathlib import Path

import pytest

from particlecli.cli.new import templates
from particlecli.scene.load import load_scene
from tests.cli.conftest import Cli


@pytest.mark.parametrize("template", templates())
def test_every_template_is_a_valid_scene(cli: Cli, tmp_path: Path, template: str) -> None:
    result = cli("new", "mine", "--from", template)
    assert result.returncode == 0
    assert "particlecli run mine.yaml" in result.stdout
    assert load_scene(tmp_path / "mine.yaml").title.lower() == template


def test_templates_that_help_names_exist() -> None:
    assert templates() == ["fountain", "smoke", "sparks"]


def test_nothing_is_overwritten(cli: Cli, scene: Path) -> None:
    before = scene.read_text()
    result = cli("new", "balls")
    assert result.returncode == 2
    assert "balls.yaml exists already" in result.stderr
    assert scene.read_text() == before


def test_unknown_template_suggests_the_nearest(cli: Cli, tmp_path: Path) -> None:
    result = cli("new", "mine", "--from", "fontain")
    assert result.returncode == 2
    assert "did you mean fountain?" in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_missing_folder_is_an_output_error(cli: Cli) -> None:
    assert cli("new", "nowhere/mine").returncode == 4

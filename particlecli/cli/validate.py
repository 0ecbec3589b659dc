"""`particlecli validate`: checks scenes without building anything."""

from __future__ import annotations

import typer

from particlecli.cli.console import message
from particlecli.cli.options import Overrides, SceneFiles
from particlecli.cli.scenes import load
from particlecli.errors import ParticleError


def command(
    scenes: SceneFiles,
    overrides: Overrides = None,
) -> None:
    """Check scenes and print every problem with its line and column."""
    worst = 0
    for scene in scenes:
        try:
            load(scene, overrides)
        except ParticleError as error:
            message(str(error))
            worst = max(worst, error.exit_code)
        else:
            typer.echo(f"{scene}: valid")
    if worst:
        raise typer.Exit(worst)

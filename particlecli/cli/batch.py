"""`particlecli batch`: many scenes and sweeps over their values."""

from __future__ import annotations

import json as json_module
import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from particlecli.cli.console import message
from particlecli.cli.options import Quiet

if TYPE_CHECKING:
    from particlecli.batch.jobs import Job

Folder = Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="Folder of the batch.")]
Jobs = Annotated[
    int | None, typer.Option("--jobs", metavar="N", min=1, help="Runs at once, at most.  [default: one a core]")
]
Force = Annotated[bool, typer.Option("--force", help="Run also what is up to date.")]
PictureQuality = Annotated[Literal["draft", "final"], typer.Option("--quality", help="draft: half the resolution.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the outcome as JSON.")]


def command(
    scenes: Annotated[list[str], typer.Argument(metavar="SCENE...", help="Scene files or globs (YAML).")],
    sweeps: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUES",
            help="Change a value, or run every one of several: integrator.dt=0.01,0.005 or "
            "forces.0.coefficient=linspace(0,1,5), also geomspace. Given several times: every combination.",
        ),
    ] = None,
    folder: Folder = Path("outputs/batch"),
    jobs: Jobs = None,
    force: Force = False,
    quality: PictureQuality = "final",
    json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Run many scenes, and sweeps over their values, each in a process of its own.

    Each run writes into a folder of its own; index.html shows them all, manifest.json lists them. What is up
    to date is not run again. A run that fails does not stop the others; the exit code is then 1.
    """
    from particlecli.batch.jobs import find_scenes, make_jobs
    from particlecli.batch.sweep import parse_sweep

    made = make_jobs(find_scenes(scenes), [parse_sweep(each) for each in sweeps or ()], folder, quality)
    carry_out(made, folder, title=f"Batch {folder.name}", processes=jobs, force=force, json=json, quiet=quiet)


def carry_out(
    made: list[Job], folder: Path, *, title: str, processes: int | None, force: bool, json: bool, quiet: bool
) -> None:
    """Runs jobs, shows how far they are, and tells what came out.

    Raises:
        typer.Exit: with 1, some of them failed.
    """
    from particlecli.batch.batch import batch
    from particlecli.cli.batch_progress import watching

    with watching(len(made), quiet=quiet) as watcher:
        count = processes or os.cpu_count() or 1
        outcome = batch(made, folder, title=title, processes=count, force=force, watcher=watcher)
    if json:
        facts = {
            "done": outcome.done,
            "skipped": outcome.skipped,
            "failed": {name: failure.message for name, failure in outcome.failed.items()},
            "manifest": str(outcome.manifest),
            "page": str(outcome.page),
        }
        typer.echo(json_module.dumps(facts, indent=2, ensure_ascii=False))
    else:
        typer.echo(f"{len(outcome.done)} done, {len(outcome.skipped)} up to date, {len(outcome.failed)} failed")
        typer.echo(f"  wrote {outcome.manifest}\n  wrote {outcome.page}")
    for name, failure in outcome.failed.items():
        message(f"failed: {name}: {failure.message}")
    if outcome.failed:
        raise typer.Exit(1)

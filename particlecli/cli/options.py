"""Arguments and options that several commands take."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="The scene file (YAML).")]
SceneFiles = Annotated[list[Path], typer.Argument(metavar="SCENE...", help="Scene files (YAML).")]
RecordingFile = Annotated[Path, typer.Argument(metavar="FILE.rrd", help="The recording.")]
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a value of the scene, as in integrator.dt=0.01; can be given several times.",
    ),
]
OutputFolder = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="DIR", help="Output folder.  [default: outputs/<scene name>]"),
]
Threads = Annotated[
    int | None, typer.Option("--threads", metavar="N", min=1, help="Worker threads.  [default: one a core]")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No progress.")]

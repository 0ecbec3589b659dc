"""`particlecli run`: one scene to its outputs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import typer

from particlecli.cli.console import message
from particlecli.cli.options import OutputFolder, Overrides, Quiet, SceneFile, Threads
from particlecli.cli.scenes import load
from particlecli.errors import UsageError

if TYPE_CHECKING:
    from particlecli.scene.outputs import Output

Video = Annotated[
    str | None,
    typer.Option("--video", metavar="F", help="Write a video: .mp4, .webm or .gif, within the output folder."),
]
Frames = Annotated[
    str | None,
    typer.Option("--frames", metavar="DIR", help="Write a folder of PNG pictures, within the output folder."),
]
Trajectory = Annotated[
    str | None,
    typer.Option(
        "--trajectory",
        metavar="F",
        help="Write all particles at all frames: .npz or .csv, within the output folder.",
    ),
]
Rrd = Annotated[
    str | None,
    typer.Option("--rrd", metavar="F", help="Write a Rerun recording: .rrd, within the output folder."),
]


def command(
    scene: SceneFile,
    folder: OutputFolder = None,
    video: Video = None,
    frames: Frames = None,
    trajectory: Trajectory = None,
    rrd: Rrd = None,
    no_output: Annotated[bool, typer.Option("--no-output", help="Simulate only; write nothing.")] = False,
    overrides: Overrides = None,
    quality: Annotated[
        Literal["draft", "final"], typer.Option(help="draft: half the resolution and faster encoding.")
    ] = "final",
    threads: Threads = None,
    estimate: Annotated[
        bool | None,
        typer.Option(
            "--estimate/--no-estimate",
            help="Estimate the error at any cost, or not at all.  [default: at 5 % of the run's]",
            show_default=False,
        ),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
    quiet: Quiet = False,
) -> None:
    """Simulate a scene and write its outputs.

    --video, --frames, --trajectory and --rrd replace the outputs that the scene lists. A scene without outputs makes
    a video. The resolved scene and the report are written beside the outputs.
    """
    outputs = _outputs({"--video": video, "--frames": frames, "--trajectory": trajectory, "--rrd": rrd}, no_output)
    loaded = load(scene, overrides)
    from particlecli.cli.progress import progress
    from particlecli.run import RunOptions, run

    options = RunOptions(folder=folder, outputs=outputs, quality=quality, threads=threads, estimate=estimate)
    with progress(quiet=quiet) as show:
        report = run(loaded, options, show, None if quiet else message)
    if json:
        typer.echo(report.to_json())
    else:
        from particlecli.cli.summary import summary

        typer.echo(summary(report))


def _outputs(asked: dict[str, str | None], no_output: bool) -> tuple[Output, ...] | None:
    """The outputs that the flags ask for; none when they do not say."""
    given = [flag for flag, value in asked.items() if value is not None]
    if no_output and given:
        raise UsageError(f"--no-output and {given[0]} contradict each other")
    if no_output:
        return ()
    return tuple(_output(flag, asked[flag]) for flag in given) or None


def _output(flag: str, path: str | None) -> Output:
    from pydantic import ValidationError

    from particlecli.scene.outputs import FramesOutput, RecordingOutput, TrajectoryOutput, VideoOutput

    kinds: dict[str, type[Output]] = {
        "--video": VideoOutput,
        "--frames": FramesOutput,
        "--trajectory": TrajectoryOutput,
        "--rrd": RecordingOutput,
    }
    try:
        return kinds[flag].model_validate({"type": flag.removeprefix("--"), "path": path})
    except ValidationError as error:
        reason = error.errors()[0]["msg"].removeprefix("Value error, ")
        raise UsageError(f"{flag} {path}: {reason} (-o chooses the output folder)") from None

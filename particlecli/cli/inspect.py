"""`particlecli inspect`: what a recording holds."""

from __future__ import annotations

import json as json_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from particlecli.cli.console import message
from particlecli.cli.options import RecordingFile
from particlecli.errors import CheckFailedError, OutputError, UsageError

if TYPE_CHECKING:
    from particlecli.sinks.recording.reader import Recording

FrameNumber = Annotated[int | None, typer.Option("--frame", metavar="N", min=0, help="Print the particles of a frame.")]
Time = Annotated[
    float | None,
    typer.Option("--time", metavar="T", min=0, help="Print the particles of the recorded frame nearest to T s."),
]
Export = Annotated[
    Path | None,
    typer.Option(
        "--export", metavar="F", help="With --frame or --time: write the particles to a .csv or .npz instead."
    ),
]
Diff = Annotated[
    Path | None,
    typer.Option("--diff", metavar="OTHER.rrd", help="Say whether two recordings agree, and where they part (exit 1)."),
]
Tolerance = Annotated[
    float,
    typer.Option("--tolerance", metavar="M", min=0, help="With --diff: distance at which positions still agree, m."),
]
SceneCopy = Annotated[
    Path | None,
    typer.Option("--extract-scene", metavar="F", help="Write the scene to a file that can be run; - prints it."),
]
Partial = Annotated[bool, typer.Option("--partial", help="Read what is there of one that is cut short.")]


def command(
    file: RecordingFile,
    frame: FrameNumber = None,
    time: Time = None,
    export: Export = None,
    diff: Diff = None,
    tolerance: Tolerance = 0.0,
    extract_scene: SceneCopy = None,
    partial: Partial = False,
    json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")] = False,
) -> None:
    """Show what a recording holds: timelines, groups, entities, series, the scene and the report.

    A run that was killed leaves its recording under a temporary name, NAME.….partial.rrd, which can be
    inspected too.
    """
    _refuse_contradictions(frame, time, export, diff, extract_scene)
    from particlecli.sinks.recording.reader import Recording

    with Recording(file, partial=partial) as recording:
        if diff is not None:
            with Recording(diff, partial=partial) as other:
                _compare(recording, other, tolerance)
        elif extract_scene is not None:
            _extract(recording, extract_scene)
        elif frame is not None or time is not None:
            from particlecli.cli import recorded_frame

            chosen = recorded_frame.chosen(recording, frame, time)
            if export is None:
                typer.echo("\n".join(recorded_frame.lines(chosen)))
            else:
                recorded_frame.write(chosen, export)
                message(f"wrote {export}")
        else:
            from particlecli.cli import recording_summary

            facts = recording_summary.facts(recording)
            typer.echo(json_module.dumps(facts, indent=2) if json else recording_summary.text(facts, recording))


def _refuse_contradictions(
    frame: int | None, time: float | None, export: Path | None, diff: Path | None, scene: Path | None
) -> None:
    asked = {"--frame": frame, "--time": time, "--diff": diff, "--extract-scene": scene}
    given = [option for option, value in asked.items() if value is not None]
    if len(given) > 1:
        raise UsageError(f"{given[0]} and {given[1]} are two questions; ask one at a time")
    if export is not None and given not in (["--frame"], ["--time"]):
        raise UsageError("--export needs --frame N or --time T, which say what to export")
    if export is not None and export.suffix.lower() not in (".csv", ".npz"):
        raise UsageError(f"--export {export}: must end in .csv or .npz")


def _compare(ours: Recording, theirs: Recording, tolerance: float) -> None:
    from particlecli.sinks.recording.difference import difference

    found = difference(ours, theirs, tolerance)
    if found.agree:
        within = f"; no particle is more than {found.largest:.3g} m apart" if found.largest else ""
        typer.echo(f"{ours.path} and {theirs.path} agree{within}")
        return
    for parting in found.partings:
        when = "" if parting.frame is None else f" at frame {parting.frame} ({parting.time:.6g} s)"
        typer.echo(f"{parting.what}{when}: {parting.how}")
    if found.largest:
        typer.echo(f"largest distance of a particle from the same one in the other: {found.largest:.6g} m")
    for line in _scene_changes(ours, theirs):
        typer.echo(line)
    raise CheckFailedError(f"{ours.path} and {theirs.path} differ")


def _scene_changes(ours: Recording, theirs: Recording) -> list[str]:
    """The lines in which the scenes differ, their outputs aside, which come last."""
    from difflib import unified_diff

    before, after = (each.scene.partition("\noutputs:")[0].splitlines() for each in (ours, theirs))
    lines = unified_diff(before, after, lineterm="", n=0)
    changes = [line for line in lines if line[:2] not in ("--", "++", "@@")]
    return ["", "their scenes differ:", *(f"  {line}" for line in changes)] if changes else []


def _extract(recording: Recording, target: Path) -> None:
    if not recording.scene:
        raise UsageError(f"{recording.path} holds no scene: the run was stopped before it began")
    if str(target) == "-":
        typer.echo(recording.scene, nl=False)
        return
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        for name, content in recording.attachments.items():
            place = target.parent / name
            place.parent.mkdir(exist_ok=True)
            place.write_bytes(content)
        target.write_text(recording.scene, encoding="utf-8")
    except OSError as error:
        raise OutputError(f"cannot write {error.filename or target}: {error.strerror}") from None
    message(f"wrote {target}" + "".join(f" and {target.parent / name}" for name in recording.attachments))

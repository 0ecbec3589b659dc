"""The sinks by what scenes ask for."""

from __future__ import annotations

from pathlib import Path
from typing import assert_never

from particlecli.scene.model import Scene
from particlecli.scene.outputs import FramesOutput, Output, RecordingOutput, TrajectoryOutput, VideoOutput
from particlecli.sinks.base import Sink
from particlecli.sinks.images import ImagesSink
from particlecli.sinks.pending import within
from particlecli.sinks.recording.sink import RecordingSink
from particlecli.sinks.trajectory import TrajectorySink
from particlecli.sinks.video import VideoSink


def make_sink(output: Output, folder: Path, scene: Scene, *, size: tuple[int, int], draft: bool) -> Sink:
    """The sink that writes an output: the one list of what can be written.

    Args:
        output: what the scene or the command line asks for.
        folder: the output folder, which the sink does not leave.
        scene: what is simulated.
        size: width and height of the pictures, pixels.
        draft: encode faster, into larger files.

    Raises:
        UsageError: the path leaves the folder, or its ending names no known format.
    """
    path = within(folder, output.path)
    match output:
        case VideoOutput():
            return VideoSink(path, fps=scene.fps, size=size, crf=output.crf, draft=draft)
        case FramesOutput():
            return ImagesSink(path)
        case TrajectoryOutput():
            return TrajectorySink(path, every=output.every)
        case RecordingOutput():
            return RecordingSink(path, scene, every=output.every, max_points=output.max_points)
        case _:
            assert_never(output)

"""What a run writes."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from particlecli.scene.types import Count, RelativeFile, SceneModel, Whole, described


class VideoOutput(SceneModel):
    """A video; its format follows from the ending: .mp4, .webm or .gif."""

    type: Literal["video"]
    path: Annotated[str, RelativeFile((".mp4", ".webm", ".gif"))] = described(
        "file ending in .mp4, .webm or .gif, within the output folder"
    )
    crf: Whole = described("constant quality: 0 is lossless, larger is smaller and worse", default=18, ge=0, le=51)


class FramesOutput(SceneModel):
    """A folder of PNG pictures, frame_00000.png and so on."""

    type: Literal["frames"]
    path: Annotated[str, RelativeFile()] = described("folder, within the output folder", default="frames")


class TrajectoryOutput(SceneModel):
    """Every particle at every frame: time, group, id, position, velocity, temperature; .npz or .csv."""

    type: Literal["trajectory"]
    path: Annotated[str, RelativeFile((".npz", ".csv"))] = described(
        "file ending in .npz or .csv, within the output folder"
    )
    every: Count = described("write each so many frames", default=1)


class RecordingOutput(SceneModel):
    """A Rerun recording to look at from all sides: points, planes, series, the scene and the report; .rrd."""

    type: Literal["rrd"]
    path: Annotated[str, RelativeFile((".rrd",))] = described("file ending in .rrd, within the output folder")
    every: Count = described("record each so many frames", default=1)
    max_points: Count | None = described(
        "most points of a frame; of more, a fixed random choice, each group its share; none: all", default=None
    )


Output = Annotated[
    VideoOutput | FramesOutput | TrajectoryOutput | RecordingOutput,
    Field(discriminator="type"),
]

"""The sink that makes a Rerun recording of a run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from particlecli.errors import OutputError
from particlecli.frame import Curve, Frame, GroupFrame
from particlecli.render.points import PointLook
from particlecli.scene.dump import dump_scene
from particlecli.scene.look import GroupLook
from particlecli.scene.model import Scene
from particlecli.scene.portable import Attachment, portable
from particlecli.sinks.base import Image, Sink
from particlecli.sinks.pending import Pending
from particlecli.sinks.recording import layout, poses
from particlecli.sinks.recording.thinning import chosen

if TYPE_CHECKING:
    from particlecli.sinks.recording.writer import Writer


POSE = (layout.TRANSLATION, layout.QUATERNION, layout.SCALE)


class RecordingSink(Sink):
    """Records points, planes and series, and with them the scene and the report.

    Positions are recorded in single precision. The temporary file is not hidden: when the process is killed,
    it is left and holds what was sent until then. Only a complete recording takes the final name.
    """

    needs_series: ClassVar[bool] = True

    def __init__(self, path: Path, scene: Scene, *, every: int = 1, max_points: int | None = None) -> None:
        """Prepares a recording.

        Args:
            path: final name.
            scene: what is recorded.
            every: record each so many frames, the first included.
            max_points: most points of a frame; none: all.
        """
        self._scene = scene
        self._every = every
        self._most = max_points
        self._pending = Pending(path, hidden=False)
        styles = scene.look.groups
        self._looks = {name: PointLook(styles.get(name, GroupLook()), place) for place, name in enumerate(scene.groups)}
        self._frames = poses.entities(scene.frames)
        self._latest: dict[tuple[str, str], NDArray[Any]] = {}
        self._writer: Writer | None = None

    @property
    def files(self) -> tuple[Path, ...]:
        """The recording."""
        return (self._pending.path,)

    def needs(self, group: str) -> frozenset[str]:
        """What the colours of a group are computed from."""
        return self._looks[group].needs

    def open(self) -> None:
        """Starts the recording with everything that does not change."""
        self._pending.claim()
        try:
            self._start()
        except BaseException:
            self.abort()
            raise

    def _start(self) -> None:
        from particlecli.sinks.recording import stage
        from particlecli.sinks.recording.writer import Writer

        self._writer = Writer(self._pending.temporary, self._scene.title or self._scene.name, tuple(self._scene.groups))
        stage.dress(self._writer, self._scene, self._looks)
        for entity in self._frames:
            stage.show_axes(self._writer, entity, self._scene)
        scene, attachments = portable(self._scene, layout.FILES)
        self._writer.document(layout.SCENE, dump_scene(scene))
        for number, attachment in enumerate(attachments):
            self._writer.attach(f"{layout.FILES}/{number}", attachment.name, _content(attachment))
        self._writer.settle()

    def write(self, frame: Frame, image: Image | None) -> None:  # noqa: ARG002
        """Records a frame."""
        assert self._writer is not None
        if frame.index % self._every:
            return
        places_of = chosen(frame, self._most)
        for name, places in places_of.items():
            group = frame.groups[name]
            entity = f"{layout.PARTICLES}/{name}"
            self._if_changed(entity, layout.IDS, frame, _ids(group)[places])
            shades = self._looks[name].shades(group)
            if shades is not None:
                self._if_changed(entity, layout.SHADES, frame, shades[places])
            # Stacked from components, which is several times as fast as a copy of the transposed array.
            x, y, z = group.positions.T
            positions = np.stack([x[places], y[places], z[places]], axis=1, dtype=np.float32, casting="same_kind")
            self._writer.row(entity, layout.POSITIONS, frame.index, frame.time, positions)
        for name, pairs in frame.springs.items():
            if isinstance(places_of[name], slice):  # of fewer points, springs would join nothing
                ends = _ends(frame.groups[name], pairs)
                self._writer.row(f"{layout.SPRINGS}/{name}", layout.STRIPS, frame.index, frame.time, ends)
        for entity, pose in self._frames.items():
            for column, values in zip(POSE, poses.pose(pose, frame.time), strict=True):
                self._if_changed(entity, column, frame, values)
        for plot, numbers in frame.series.items():
            for name, value in numbers.items():
                self._number(f"{plot}/{name}", frame.index, frame.time, value)
        self._writer.frame_done()

    def _number(self, series: str, frame: int, time: float, value: float) -> None:
        assert self._writer is not None
        self._writer.row(f"{layout.PLOTS}/{series}", layout.SCALARS, frame, time, np.array([value], np.float64))

    def _if_changed(self, entity: str, column: str, frame: Frame, values: NDArray[Any]) -> None:
        assert self._writer is not None
        key = entity, column
        if key not in self._latest or not np.array_equal(self._latest[key], values):
            self._latest[key] = values
            self._writer.row(entity, column, frame.index, frame.time, values)

    def conclude(self, report: str, errors: Mapping[str, Curve]) -> None:
        """Records the report, and the estimated error over time."""
        assert self._writer is not None
        for group, curve in errors.items():
            for frame, time, value in zip(curve.frames, curve.times, curve.values, strict=True):
                self._number(f"{layout.ERROR}/{group}", frame, time, value)
        self._writer.document(layout.REPORT, report)

    def close(self) -> None:
        """Finishes the recording and gives it its name."""
        assert self._writer is not None
        self._writer.close()
        self._writer = None
        self._pending.commit()

    def abort(self) -> None:
        """Removes what was recorded."""
        if self._writer is not None:
            self._writer.abandon()
            self._writer = None
        self._pending.discard()


def _ends(group: GroupFrame, pairs: NDArray[np.int64]) -> NDArray[np.float32]:
    """Where springs begin and end, shape (n, 2, 3), m; of those whose two particles live."""
    if len(group) == 0:
        return np.empty((0, 2, 3), np.float32)
    places = np.minimum(np.searchsorted(group.ids, pairs), len(group) - 1)
    alive = (group.ids[places] == pairs).all(axis=1)
    return np.asarray(group.positions[places[alive]], np.float32)


def _ids(group: GroupFrame) -> NDArray[np.uint32]:
    return group.ids.astype(np.uint32)


def _content(attachment: Attachment) -> bytes:
    try:
        return attachment.source.read_bytes()
    except OSError as error:
        raise OutputError(f"cannot record {attachment.source}: {error.strerror}") from error

"""Writes recordings with Rerun."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any
from zlib import crc32

os.environ.setdefault("RUST_LOG", "off")  # what goes wrong is told in this package's words

import numpy as np
import pyarrow as pa
import rerun as rr
from numpy.typing import NDArray

from particlecli import __version__
from particlecli.errors import OutputError
from particlecli.sinks.recording import container, layout

BLOCK_BYTES = 1 << 20
"""What is gathered before it is sent: small frames share a chunk, which costs about a kilobyte of its own."""

BLOCK_SECONDS = 0.25
"""How long rows wait at most; a killed process loses no more."""

SPARE_BYTES = 32 << 20
"""What must be free on the disk beyond the next block: blocks on the way there, and the end of the file."""

DISK_SECONDS = 60.0
"""How long the disk may take for what is written first."""

_CORNER = pa.list_(pa.field("item", pa.float32(), nullable=False), 3)
_STRIP = pa.list_(pa.field("item", _CORNER, nullable=False))


def _strips(ends: NDArray[np.float32]) -> rr.AnyBatchValue:
    """Strips of two points each, shape (n, 2, 3); Rerun's own batch takes them one by one."""
    corners = pa.FixedSizeListArray.from_arrays(pa.array(ends.reshape(-1)), type=_CORNER)
    offsets = pa.array(np.arange(len(ends) + 1, dtype=np.int32) * 2)
    strips = pa.ListArray.from_arrays(offsets, corners, type=_STRIP)
    return rr.AnyBatchValue(rr.LineStrips3D.descriptor_strips(), strips)


_COLUMNS: dict[str, tuple[rr.ComponentDescriptor, Callable[[NDArray[Any]], Any]]] = {
    layout.POSITIONS: (rr.Points3D.descriptor_positions(), rr.components.Position3DBatch),
    layout.SHADES: (rr.Points3D.descriptor_class_ids(), rr.components.ClassIdBatch),
    layout.SCALARS: (rr.Scalars.descriptor_scalars(), rr.components.ScalarBatch),
    layout.STRIPS: (rr.LineStrips3D.descriptor_strips(), _strips),
    layout.TRANSLATION: (rr.Transform3D.descriptor_translation(), rr.components.Translation3DBatch),
    layout.QUATERNION: (rr.Transform3D.descriptor_quaternion(), rr.components.RotationQuatBatch),
    layout.SCALE: (rr.Transform3D.descriptor_scale(), rr.components.Scale3DBatch),
    layout.IDS: (rr.ComponentDescriptor(layout.IDS), lambda ids: rr.AnyBatchValue(layout.IDS, pa.array(ids))),
}


class Writer:
    """A recording being written: rows of columns over time, and what does not change.

    Args:
        path: the file to write.
        title: the name that the viewer shows.
        groups: names of the groups of particles, in order.

    Raises:
        OutputError: the file cannot be written; also from every method that sends.
    """

    def __init__(self, path: Path, title: str, groups: Sequence[str]) -> None:
        self._path = path
        self._stream = rr.RecordingStream(layout.APPLICATION)
        self._rows: dict[tuple[str, str], list[tuple[int, float, NDArray[Any]]]] = {}
        self._bytes = 0
        self._sent = time.monotonic()
        try:
            self._stream.save(path)
        except RuntimeError as error:
            raise OutputError(f"cannot write {path}: {error}") from None
        self._stream.send_recording_name(title)
        about = {
            layout.ABOUT_TITLE: [title],
            layout.ABOUT_VERSION: [__version__],
            layout.ABOUT_GROUPS: pa.array(groups, pa.string()),
        }
        self._stream.send_property(layout.ABOUT, rr.AnyValues(**about))

    def blueprint(self, blueprint: Any) -> None:
        """How the viewer lays the recording out."""
        self._stream.send_blueprint(blueprint)

    def constant(self, entity: str, *components: Any) -> None:
        """Logs what does not change."""
        self._stream.log(entity, *components, static=True)

    def document(self, entity: str, text: str) -> None:
        """Logs a text that does not change."""
        self.constant(entity, rr.TextDocument(text, media_type=rr.MediaType.TEXT))

    def attach(self, entity: str, name: str, content: bytes) -> None:
        """Logs a file."""
        names, contents = pa.array([name]), pa.array([content], pa.binary())
        self.constant(entity, rr.AnyValues(**{layout.FILE_NAME: names, layout.FILE_CONTENT: contents}))

    def settle(self) -> None:
        """Waits until what does not change is in the file; Rerun keeps it for a while, and a kill would lose it."""
        self._find_room()
        try:
            self._stream.flush(timeout_sec=DISK_SECONDS)
        except (RuntimeError, ValueError) as error:
            raise OutputError(f"cannot write {self._path}: {error}") from None

    def row(self, entity: str, column: str, frame: int, at: float, values: NDArray[Any]) -> None:
        """Adds what a column, one of `layout`, holds from a frame on; keeps the array."""
        self._rows.setdefault((entity, column), []).append((frame, at, values))
        self._bytes += values.nbytes

    def frame_done(self) -> None:
        """Sends what was gathered, if it is much or old."""
        if self._bytes >= BLOCK_BYTES or time.monotonic() - self._sent >= BLOCK_SECONDS:
            self.send()

    def send(self) -> None:
        """Sends all rows."""
        self._find_room()
        for (entity, column), rows in self._rows.items():
            self._send(entity, column, rows)
        self._rows.clear()
        self._bytes = 0
        self._sent = time.monotonic()

    def _send(self, entity: str, column: str, rows: Sequence[tuple[int, float, NDArray[Any]]]) -> None:
        frames, times, values = zip(*rows, strict=True)
        descriptor, batch = _COLUMNS[column]
        joined = values[0] if len(values) == 1 else np.concatenate(values)
        indexes = [
            rr.TimeColumn(layout.FRAME, sequence=frames),
            rr.TimeColumn(layout.TIME, duration=times),
        ]
        component = rr.ComponentColumn(descriptor, batch(joined), lengths=[len(each) for each in values])
        name, sums = (
            layout.sums_of(column),
            pa.array([crc32(np.ascontiguousarray(each).data) for each in values], pa.uint32()),
        )
        checks = rr.ComponentColumn(rr.ComponentDescriptor(name), rr.AnyBatchValue(name, sums))
        self._stream.send_columns(entity, indexes=indexes, columns=[component, checks])

    def _find_room(self) -> None:
        # Rerun's writer thread ends when the disk is full, and whoever waits for it then waits forever.
        free = shutil.disk_usage(self._path.parent).free
        if free < SPARE_BYTES + self._bytes:
            raise OutputError(f"cannot write {self._path}: the disk is full ({free >> 20} MB are left)")

    def close(self) -> None:
        """Sends the rest, and finishes the file.

        Raises:
            OutputError: not all of it has reached the disk.
        """
        self.send()
        self._stream.disconnect()
        if not container.is_finished(self._path):
            raise OutputError(f"cannot write {self._path}: not all of it has reached the disk")

    def abandon(self) -> None:
        """Lets go of the file."""
        self._stream.disconnect()

"""Reads recordings back."""

from __future__ import annotations

import os
import shutil
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self
from zlib import crc32

os.environ.setdefault("RUST_LOG", "off")  # what goes wrong is told in this package's words

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from rerun.chunk import RrdReader

from particlecli.errors import UsageError
from particlecli.sinks.pending import PARTIAL
from particlecli.sinks.recording import container, layout

Row = tuple[int, float, NDArray[Any]]
"""Frame, time in s, values."""


@dataclass(frozen=True)
class Points:
    """The recorded particles of a group at a frame.

    Attributes:
        group, frame: whose and which.
        time: s.
        ids: shape (n,).
        positions: shape (n, 3), m.
        colors: 0xRRGGBBAA, shape (n,), or (1,) where all are alike.
    """

    group: str
    frame: int
    time: float
    ids: NDArray[np.uint32]
    positions: NDArray[np.float32]
    colors: NDArray[np.uint32]


@dataclass(frozen=True)
class Series:
    """A number over time: all of shape (n,); times in s."""

    frames: NDArray[np.int64]
    times: NDArray[np.float64]
    values: NDArray[np.float64]


class Recording:
    """A recording of a run, open for reading. Use it in a `with` block.

    Args:
        path: the file.
        partial: whether to read what there is of one that has no end; a temporary name says so too.

    Attributes:
        path, container: the file, and the outside of it.
        title: of the scene.
        version: of the particlecli that recorded it.
        groups: names, in the order of the scene.
        series: by name, such as `deaths/sparks/expired`.
        scene: the resolved scene, YAML; "" where it is missing.
        report: the report, JSON; none for a run that did not come to its end.
        attachments: data files of the scene: content by name.
        entities: names of all that is recorded.

    Raises:
        UsageError: not a recording of a run, of another version of Rerun, damaged, or cut short.
    """

    def __init__(self, path: Path, *, partial: bool = False) -> None:
        self.path = path
        self.container = container.examine(path)
        self._exit = ExitStack()
        if not self.container.finished and not partial and PARTIAL not in path.suffixes:
            raise UsageError(
                f"{path} is cut short: the copy is incomplete, or the run was killed; --partial reads what is there"
            )
        self.groups: tuple[str, ...] = ()
        self.series: dict[str, Series] = {}
        self.attachments: dict[str, bytes] = {}
        self.entities: tuple[str, ...] = ()
        self.scene = ""
        self.report: str | None = None
        with self._damage_told():
            self._store = self._opened()
            self._read()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._exit.close()

    def points(self, group: str) -> Iterator[Points]:
        """The recorded frames of a group, in order."""
        entity = f"/{layout.PARTICLES}/{group}"
        with self._damage_told():
            ids = _Held(self._rows(entity, layout.IDS))
            palette, shades = self._palette(entity), _Held(self._rows(entity, layout.SHADES))
            for frame, time, positions in self._rows(entity, layout.POSITIONS):
                colors = palette if len(palette) == 1 else palette[shades.at(frame)]
                yield Points(group, frame, time, ids.at(frame), positions, colors)

    def positions(self, group: str) -> Iterator[Row]:
        """As `points`, of the positions alone: frame, time and positions."""
        with self._damage_told():
            yield from self._rows(f"/{layout.PARTICLES}/{group}", layout.POSITIONS)

    def _opened(self) -> Any:
        path = self.path
        if not self.container.finished and self.container.whole < self.container.size:
            path = self._exit.enter_context(_trimmed(self.path, self.container.whole))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that a recording has no end is known, and told
            reader = RrdReader(path)
        stores = reader.recordings()
        if not stores:
            raise UsageError(f"{self.path} is cut short: nothing of the recording is left")
        if stores[0].application_id != layout.APPLICATION:
            raise UsageError(f"{self.path} is no recording of a particlecli run; {stores[0].application_id} wrote it")
        return reader.store(store=stores[0]) if self.container.finished else _Unindexed(reader, stores[0])

    def _read(self) -> None:
        blocks: dict[str, list[pa.RecordBatch]] = {}
        for chunk in self._store.stream().filter(content=["+ /**", "+ /__properties/**", f"- /{layout.PARTICLES}/**"]):
            blocks.setdefault(str(chunk.entity_path), []).append(chunk.to_record_batch())
        prefix = f"/{layout.PLOTS}/"
        for name, batches in blocks.items():
            if name.startswith(prefix):
                self.series[name.removeprefix(prefix)] = _series(batches)
            elif name.startswith(f"/{layout.FILES}/"):
                self.attachments[_first(batches, layout.FILE_NAME)] = _first(batches, layout.FILE_CONTENT)
        about = blocks.get(f"/__properties/{layout.ABOUT}", [])
        self.title = _first(about, layout.ABOUT_TITLE) or ""
        self.version = _first(about, layout.ABOUT_VERSION) or ""
        self.groups = tuple(_all(about, layout.ABOUT_GROUPS))
        self.entities = (*blocks, *(f"/{layout.PARTICLES}/{group}" for group in self.groups))
        self.scene = _first(blocks.get(f"/{layout.SCENE}", []), layout.TEXT) or ""
        self.report = _first(blocks.get(f"/{layout.REPORT}", []), layout.TEXT)

    def _rows(self, entity: str, column: str) -> Iterator[Row]:
        columns = [column, layout.sums_of(column)]
        for chunk in self._store.stream().filter(content=entity, components=columns):
            yield from _rows(chunk.to_record_batch(), column)

    def _palette(self, entity: str) -> NDArray[np.uint32]:
        """The colours of a group, 0xRRGGBBAA."""
        for chunk in self._store.stream().filter(content=entity, is_static=True):
            batch = chunk.to_record_batch()
            if layout.COLORS in batch.schema.names:
                return np.asarray(batch.column(layout.COLORS).values.to_numpy())
            if layout.PALETTE in batch.schema.names:
                classes = batch.column(layout.PALETTE).values.values.field("class_description")
                return np.asarray(classes.field("info").field("color").to_numpy())
        raise ValueError(f"{entity} has no colours")

    @contextmanager
    def _damage_told(self) -> Iterator[None]:
        try:
            yield
        except (RuntimeError, ValueError, OSError, pa.ArrowException) as error:
            self._exit.close()
            raise UsageError(f"{self.path} cannot be read, it is damaged: {error}") from None
        except UsageError:
            self._exit.close()
            raise


class _Unindexed:
    """A recording without an end, as a store: every stream reads the whole file."""

    def __init__(self, reader: RrdReader, store: Any) -> None:
        self._reader = reader
        self._store = store

    def stream(self) -> Any:
        return self._reader.stream(store=self._store)


class _Held:
    """Rows of which each holds until the next one."""

    def __init__(self, rows: Iterator[Row]) -> None:
        self._rows = rows
        self._next = next(rows, None)
        self._values: NDArray[Any] = np.empty(0, np.uint32)

    def at(self, frame: int) -> NDArray[Any]:
        """The values at a frame; frames must not go back."""
        while self._next is not None and self._next[0] <= frame:
            self._values = self._next[2]
            self._next = next(self._rows, None)
        return self._values


def _rows(batch: pa.RecordBatch, column: str) -> Iterator[Row]:
    """The rows of a column; those whose bytes are not what was written are damage (ValueError)."""
    frames, times = _index(batch)
    lists = batch.column(column)
    offsets = lists.offsets.to_numpy()
    values = lists.values
    width = 1
    if isinstance(values, pa.FixedSizeListArray):
        width = values.type.list_size
        values = values.values
    flat = values.to_numpy(zero_copy_only=False)
    name = layout.sums_of(column)
    sums = batch.column(name).values.to_numpy() if name in batch.schema.names else None
    for place, frame in enumerate(frames):
        part = flat[offsets[place] * width : offsets[place + 1] * width]
        if sums is not None and crc32(part) != sums[place]:
            raise ValueError(f"frame {frame} is not what was written")
        yield int(frame), float(times[place]), part.reshape(-1, width) if width > 1 else part


def _index(batch: pa.RecordBatch) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    nanoseconds = batch.column(layout.TIME).cast(pa.int64()).to_numpy()
    return batch.column(layout.FRAME).to_numpy(), nanoseconds / 1e9


def _series(batches: list[pa.RecordBatch]) -> Series:
    frames, times, values = zip(*(row for batch in batches for row in _rows(batch, layout.SCALARS)), strict=True)
    return Series(np.array(frames), np.array(times), np.concatenate(values))


def _first(batches: list[pa.RecordBatch], column: str) -> Any:
    return next(iter(_all(batches, column)), None)


def _all(batches: list[pa.RecordBatch], column: str) -> list[Any]:
    return [
        value for batch in batches if column in batch.schema.names for value in batch.column(column).values.to_pylist()
    ]


@contextmanager
def _trimmed(path: Path, size: int) -> Iterator[Path]:
    """A copy of the first bytes of a file."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / path.name
        with path.open("rb") as source, copy.open("wb") as target:
            shutil.copyfileobj(source, target)
            target.truncate(size)
        yield copy

"""A folder of PNG pictures, one a frame."""

from __future__ import annotations

import os
import re
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import ClassVar

from particlecli.errors import OutputError
from particlecli.frame import Frame
from particlecli.sinks import png
from particlecli.sinks.base import Image, Sink
from particlecli.sinks.pending import Pending, writing

_NAME = "frame_{:05d}.png"
_OURS = re.compile(r"frame_\d{5,}\.png")
_WORKERS = min(4, os.cpu_count() or 1)


class ImagesSink(Sink):
    """Writes frame_00000.png, frame_00001.png … into a folder; the pictures are compressed side by side."""

    needs_image: ClassVar[bool] = True

    def __init__(self, path: Path) -> None:
        self._pending = Pending(path, folder=True)
        self._pool: ThreadPoolExecutor | None = None
        self._jobs: deque[Future[None]] = deque()

    @property
    def files(self) -> tuple[Path, ...]:
        """The folder."""
        return (self._pending.path,)

    def open(self) -> None:
        """Makes the temporary folder.

        Raises:
            OutputError: it cannot be written, or the folder to replace holds other things than frames.
        """
        folder = self._pending.path
        if folder.is_dir():
            foreign = [entry.name for entry in folder.iterdir() if not _OURS.fullmatch(entry.name)]
            if foreign:
                raise OutputError(f"will not replace the folder {folder}: it also holds {min(foreign)!r}")
        self._pending.claim()
        self._pool = ThreadPoolExecutor(_WORKERS, thread_name_prefix="png")

    def write(self, frame: Frame, image: Image | None) -> None:
        """Queues the picture for compression; waits when too many are queued."""
        assert self._pool is not None
        assert image is not None
        while len(self._jobs) >= 2 * _WORKERS:
            self._jobs.popleft().result()
        path = self._pending.temporary / _NAME.format(frame.index)
        self._jobs.append(self._pool.submit(_save, image.copy(), path))

    def close(self) -> None:
        """Waits for the last pictures and gives the folder its name."""
        assert self._pool is not None
        while self._jobs:
            self._jobs.popleft().result()
        self._pool.shutdown()
        self._pool = None
        self._pending.commit()

    def abort(self) -> None:
        """Drops the queue and the temporary folder."""
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)
            self._pool = None
            self._pending.discard()


def _save(image: Image, path: Path) -> None:
    with writing(path):
        path.write_bytes(png.encode(image))

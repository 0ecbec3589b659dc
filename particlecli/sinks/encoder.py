"""An ffmpeg process, fed with pictures by a thread.

ffmpeg is driven directly rather than through imageio's writer, which drops ffmpeg's exit code and messages:
a disk that fills up while the last bytes are written would leave a broken video under its final name.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import tempfile
import threading
from pathlib import Path
from queue import Queue

import imageio_ffmpeg

from particlecli.errors import OutputError
from particlecli.sinks.base import Image

_QUEUED_PICTURES = 4
_NICENESS = 15
_LAST_WORDS = 600  # characters of ffmpeg's messages that an error repeats


class Encoder:
    """Runs ffmpeg beside the simulation: a short queue of pictures, a thread that feeds it.

    The encoder has its own process group, for Ctrl-C is meant for the run, which then stops the encoder.
    """

    def __init__(self, arguments: list[str], path: Path) -> None:
        """Starts ffmpeg.

        Args:
            arguments: ffmpeg's, from the input on.
            path: the file it writes.

        Raises:
            OutputError: ffmpeg cannot be started.
        """
        self._path = path
        self._messages = tempfile.TemporaryFile()  # noqa: SIM115 - lives as long as the process
        try:
            self._process = subprocess.Popen(
                [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-v", "error", *arguments, str(path)],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=self._messages,
                process_group=0,
                creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
            )
        except (OSError, RuntimeError) as error:
            self._messages.close()
            raise OutputError(f"cannot start the video encoder: {error}") from error
        self._yield()
        self._queue: Queue[Image | None] = Queue(_QUEUED_PICTURES)
        self._failed = threading.Event()
        self._feeder = threading.Thread(target=self._feed, name="encoder", daemon=True)
        self._feeder.start()

    def _yield(self) -> None:
        """Let the run go first where both want a core: it waits for each of its threads, many times a picture."""
        if hasattr(os, "setpriority"):
            with contextlib.suppress(OSError):  # it has ended already, which the first picture will tell
                os.setpriority(os.PRIO_PROCESS, self._process.pid, _NICENESS)

    def write(self, image: Image) -> None:
        """Queues a picture, which must not change afterwards; waits while the encoder is behind.

        Raises:
            OutputError: the encoder has failed; carries its last words.
        """
        if self._failed.is_set():
            raise self._failure()
        self._queue.put(image)

    def finish(self) -> None:
        """Waits until the file is complete.

        Raises:
            OutputError: the encoder has failed; carries its last words.
        """
        self._queue.put(None)
        self._feeder.join()
        if self._process.wait() != 0 or self._failed.is_set():
            raise self._failure()
        self._messages.close()

    def kill(self) -> None:
        """Stops at once, leaving the file broken."""
        self._process.kill()
        self._failed.set()
        self._queue.put(None)
        self._feeder.join()
        self._process.wait()
        self._messages.close()

    def _feed(self) -> None:
        """Passes pictures on until None comes; once the encoder has failed, only empties the queue."""
        pipe = self._process.stdin
        assert pipe is not None
        while (image := self._queue.get()) is not None:
            if not self._failed.is_set():
                try:
                    pipe.write(image.data)
                except OSError:
                    self._failed.set()
        try:
            pipe.close()
        except OSError:
            self._failed.set()

    def _failure(self) -> OutputError:
        status = self._process.wait()
        self._messages.seek(0)
        words = self._messages.read().decode(errors="replace").strip()[-_LAST_WORDS:]
        said = f"; it said:\n{words}" if words else ""
        return OutputError(f"the video encoder failed (exit code {status}){said}")

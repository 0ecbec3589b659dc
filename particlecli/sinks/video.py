"""Videos: MP4 (H.264), WebM (VP9) and GIF; encoding overlaps simulation and rendering."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import ClassVar

import numpy as np

from particlecli.errors import UsageError
from particlecli.frame import Frame
from particlecli.sinks.base import Image, Sink
from particlecli.sinks.encoder import Encoder
from particlecli.sinks.pending import Pending

_THREADS = ["-threads", "4"]
"""Fixed, for the number of threads changes the bytes that x264 and libvpx make."""

_REPRODUCIBLE = ["-fflags", "+bitexact", "-flags:v", "+bitexact"]
"""No random track identifiers and no version strings."""

_BT709 = [
    "-vf",
    "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int+bitexact,format=yuv420p,"
    "setparams=colorspace=bt709:color_primaries=bt709:color_trc=bt709:range=tv",
]
"""Converts to the colours of HD video and says so; untagged, players guess and colours shift."""


def _mp4(crf: int, draft: bool) -> list[str]:
    # aq-mode 3 spends bits on the dark: smooth glow on black is where H.264 shows bands.
    # B-frames and the macroblock tree give superfast the size of veryfast, to a tenth, at two thirds of its time.
    speed = ["ultrafast"] if draft else ["superfast", "-bf", "3", "-rc-lookahead", "10", "-mbtree", "1"]
    return [*_BT709, "-c:v", "libx264", "-preset", *speed, "-aq-mode", "3", "-crf", str(crf), "-movflags", "+faststart"]


def _webm(crf: int, draft: bool) -> list[str]:
    speed = ["-deadline", "realtime", "-cpu-used", "8" if draft else "6", "-row-mt", "1"]
    # VP9 counts quality from 0 to 63 where H.264 goes to 51.
    return [*_BT709, "-c:v", "libvpx-vp9", *speed, "-b:v", "0", "-crf", str(round(crf * 63 / 51))]


def _gif(crf: int, draft: bool) -> list[str]:  # noqa: ARG001
    # A palette for each picture: one for all would need every picture in memory at once.
    # GIF counts hundredths of a second, and viewers slow down what is faster than 50 a second.
    palette = "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1"
    return ["-filter_complex", f"[0:v]fps='min(source_fps,50)',{palette}", "-c:v", "gif"]


_ENCODERS = {".mp4": _mp4, ".webm": _webm, ".gif": _gif}


class VideoSink(Sink):
    """Encodes the pictures into one file; the ending chooses the format."""

    needs_image: ClassVar[bool] = True

    def __init__(self, path: Path, *, fps: float, size: tuple[int, int], crf: int = 18, draft: bool = False) -> None:
        """Prepares a video.

        Args:
            path: final name, ending in .mp4, .webm or .gif.
            fps: pictures a second; fractions such as 30000/1001 are kept exactly.
            size: width and height of the pictures, pixels; odd ones are padded by repeating the edge.
            crf: constant quality as H.264 counts it, 0 (lossless) to 51; GIF has no use for it.
            draft: encode faster, into a larger file.

        Raises:
            UsageError: an ending that names no known format.
        """
        encoder = _ENCODERS.get(path.suffix.lower())
        if encoder is None:
            raise UsageError(f"a video ends in {', '.join(_ENCODERS)}; {path.name!r} does not")
        self._pending = Pending(path)
        self._even = path.suffix.lower() != ".gif"
        width, height = (side + side % 2 for side in size) if self._even else size
        rate = Fraction(fps).limit_denominator(1_000_000)
        pictures = f"-f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {rate} -i -".split()
        self._arguments = [*pictures, *encoder(crf, draft), *_THREADS, *_REPRODUCIBLE]
        self._encoder: Encoder | None = None

    @property
    def files(self) -> tuple[Path, ...]:
        """The video."""
        return (self._pending.path,)

    def open(self) -> None:
        """Starts the encoder."""
        self._pending.claim()
        try:
            self._encoder = Encoder(self._arguments, self._pending.temporary)
        except BaseException:
            self._pending.discard()
            raise

    def write(self, frame: Frame, image: Image | None) -> None:  # noqa: ARG002
        """Queues the picture; waits while the encoder is behind."""
        assert self._encoder is not None
        assert image is not None
        height, width, _ = image.shape
        odd = ((0, height % 2), (0, width % 2), (0, 0)) if self._even else ((0, 0),) * 3
        self._encoder.write(np.pad(image, odd, mode="edge") if any(map(sum, odd)) else image.copy())

    def close(self) -> None:
        """Waits for the encoder to finish and gives the video its name."""
        assert self._encoder is not None
        self._encoder.finish()
        self._encoder = None
        self._pending.commit()

    def abort(self) -> None:
        """Kills the encoder and removes what it wrote."""
        if self._encoder is not None:
            self._encoder.kill()
            self._encoder = None
            self._pending.discard()

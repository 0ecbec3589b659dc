"""Small pictures of what a run made."""

from __future__ import annotations

import io
import subprocess
from collections.abc import Sequence
from pathlib import Path

VIDEOS = (".mp4", ".webm", ".gif")

WIDTH = 480
QUALITY = 80
LATE = 0.6
"""The moment of a video or the place among pictures that is shown, as a share: by then there is something to see."""


def thumbnail(files: Sequence[Path], duration: float) -> bytes | None:
    """A JPEG of the first video, or folder of pictures, among the files; none where there is neither.

    Args:
        files: what a run wrote.
        duration: of the video, s.
    """
    for file in files:
        if file.suffix.lower() in VIDEOS and file.is_file():
            return _of_video(file, LATE * duration)
        if file.is_dir() and (pictures := sorted(file.glob("*.png"))):
            return _of_picture(pictures[int(LATE * (len(pictures) - 1))])
    return None


def _of_video(file: Path, time: float) -> bytes | None:
    import imageio_ffmpeg

    wanted = ["-frames:v", "1", "-vf", f"scale={WIDTH}:-2", "-f", "image2pipe", "-c:v", "mjpeg", "-q:v", "4", "-"]
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-ss", f"{time:.3f}", "-i", str(file), *wanted]
    picture = subprocess.run(command, capture_output=True, check=False).stdout
    return picture or None


def _of_picture(file: Path) -> bytes:
    from PIL import Image

    with Image.open(file) as picture:
        picture.thumbnail((WIDTH, WIDTH))
        out = io.BytesIO()
        picture.convert("RGB").save(out, "JPEG", quality=QUALITY)
    return out.getvalue()

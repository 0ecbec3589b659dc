"""Frames and pictures to write, and ffmpeg to read back."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from numpy.typing import NDArray

from particlecli.frame import Frame, GroupFrame

Images = NDArray[np.uint8]


@pytest.fixture
def empty_frames() -> Callable[[int], list[Frame]]:
    """So many frames without groups."""
    return lambda count: [Frame(index, index / 30, {}) for index in range(count)]


@pytest.fixture
def particle_frames() -> list[Frame]:
    """Three frames of a newtonian group that grows and a first-order one, single precision."""
    rng = np.random.default_rng(5)

    def numbers(*shape: int) -> NDArray[np.float32]:
        return rng.normal(size=shape).astype(np.float32)

    return [
        Frame(
            index,
            index / 30,
            {
                "sparks": GroupFrame(np.arange(index), numbers(index, 3), velocities=numbers(index, 3)),
                "smoke": GroupFrame(np.arange(2) + 7, numbers(3, 2).T, temperatures=numbers(2)),
            },
        )
        for index in range(3)
    ]


@pytest.fixture
def decode() -> Callable[[Path], Images]:
    """Reads a video with ffmpeg: shape (pictures, height, width, 3)."""

    def read(path: Path) -> Images:
        ffmpeg = imageio_ffmpeg.get_ffmpeg_exe()
        width, height = next(imageio_ffmpeg.read_frames(path))["source_size"]
        raw = ["-fps_mode", "passthrough", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
        result = subprocess.run([ffmpeg, "-v", "error", "-i", path, *raw], capture_output=True, check=True)
        return np.frombuffer(result.stdout, np.uint8).reshape(-1, height, width, 3)

    return read


@pytest.fixture
def described() -> Callable[[Path], str]:
    """What ffmpeg says about the video stream of a file."""

    def describe(path: Path) -> str:
        command = [imageio_ffmpeg.get_ffmpeg_exe(), "-hide_banner", "-i", path]
        messages = subprocess.run(command, capture_output=True, text=True, check=False).stderr
        return next(line for line in messages.splitlines() if "Video:" in line)

    return describe

from __future__ import annotations

import itertools
import os
import stat
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from particlecli.errors import OutputError, UsageError
from particlecli.frame import Frame
from particlecli.sinks.encoder import Encoder
from particlecli.sinks.video import VideoSink

Frames = Callable[[int], list[Frame]]
Decode = Callable[[Path], NDArray[np.uint8]]

PATCHES = [(255, 0, 0), (0, 255, 0), (0, 0, 255), (128, 128, 128), (255, 255, 255), (0, 0, 0), (200, 100, 30)]
SIZE = (16 * len(PATCHES), 32)


def patches() -> NDArray[np.uint8]:
    return np.repeat(np.array([PATCHES], np.uint8), 16, axis=1).repeat(32, axis=0)


def write(path: Path, pictures: list[NDArray[np.uint8]], fps: float = 30.0) -> VideoSink:
    height, width, _ = pictures[0].shape
    sink = VideoSink(path, fps=fps, size=(width, height))
    sink.open()
    buffer = np.empty_like(pictures[0])
    for index, picture in enumerate(pictures):
        buffer[:] = picture
        sink.write(Frame(index, index / fps, {}), buffer)
        buffer[:] = 77
    assert not path.exists()
    sink.close()
    return sink


@pytest.mark.parametrize("ending", ["mp4", "webm", "gif"])
def test_pictures_read_back_in_number_size_and_colour(tmp_path: Path, decode: Decode, ending: str) -> None:
    write(tmp_path / f"a.{ending}", [patches()] * 9)
    read = decode(tmp_path / f"a.{ending}")
    assert read.shape == (9, 32, 16 * len(PATCHES), 3)
    for index, colour in enumerate(PATCHES):
        middle = read[:, 8:24, 16 * index + 5 : 16 * index + 11].astype(int)
        assert np.abs(middle - colour).max() <= 4, (colour, middle[0, 0, 0])
    assert [entry.name for entry in tmp_path.iterdir()] == [f"a.{ending}"]


@pytest.mark.parametrize("ending", ["mp4", "webm"])
def test_colours_are_tagged(tmp_path: Path, described: Callable[[Path], str], ending: str) -> None:
    write(tmp_path / f"a.{ending}", [patches()] * 2)
    assert "yuv420p(tv, bt709, progressive)" in described(tmp_path / f"a.{ending}")


@pytest.mark.parametrize(("ending", "codec"), [("mp4", "h264"), ("webm", "vp9"), ("gif", "gif")])
def test_ending_chooses_the_codec(tmp_path: Path, described: Callable[[Path], str], ending: str, codec: str) -> None:
    write(tmp_path / f"a.{ending.upper()}", [patches()] * 2)
    assert f"Video: {codec}" in described(tmp_path / f"a.{ending.upper()}")


def test_video_can_be_watched_while_it_loads(tmp_path: Path) -> None:
    write(tmp_path / "a.mp4", [patches()] * 2)
    content = (tmp_path / "a.mp4").read_bytes()
    assert content.index(b"moov") < content.index(b"mdat")


@pytest.mark.parametrize("ending", ["mp4", "webm", "gif"])
def test_same_pictures_same_bytes(tmp_path: Path, ending: str) -> None:
    rng = np.random.default_rng(3)
    pictures = [rng.integers(0, 255, (48, 64, 3), np.uint8) for _ in range(12)]
    for name in "ab":
        write(tmp_path / f"{name}.{ending}", pictures)
    assert (tmp_path / f"a.{ending}").read_bytes() == (tmp_path / f"b.{ending}").read_bytes()


@pytest.mark.parametrize("ending", ["mp4", "webm"])
def test_odd_sizes_grow_by_repeating_the_edge(tmp_path: Path, decode: Decode, ending: str) -> None:
    write(tmp_path / f"a.{ending}", [np.full((31, 45, 3), 200, np.uint8)] * 3)
    read = decode(tmp_path / f"a.{ending}")
    assert read.shape == (3, 32, 46, 3)
    assert np.abs(read.astype(int) - 200).max() <= 3


def test_odd_sizes_stay_in_a_gif(tmp_path: Path, decode: Decode) -> None:
    write(tmp_path / "a.gif", [np.full((31, 45, 3), 200, np.uint8)] * 3)
    assert decode(tmp_path / "a.gif").shape == (3, 31, 45, 3)


@pytest.mark.parametrize(("fps", "rate"), [(30000 / 1001, "29.97 fps"), (12.5, "12.50 fps"), (60, "60 fps")])
def test_fractional_frame_rates_are_kept(
    tmp_path: Path, described: Callable[[Path], str], fps: float, rate: str
) -> None:
    write(tmp_path / "a.mp4", [patches()] * 30, fps)
    assert rate in described(tmp_path / "a.mp4").replace("12.5 fps", "12.50 fps")


def test_gif_is_not_faster_than_viewers_show(tmp_path: Path, decode: Decode) -> None:
    pictures = [np.full((16, 16, 3), 2 * index, np.uint8) for index in range(100)]
    write(tmp_path / "a.gif", pictures, fps=100)
    assert abs(len(decode(tmp_path / "a.gif")) - 50) <= 1


def test_aborted_video_leaves_nothing(tmp_path: Path) -> None:
    sink = VideoSink(tmp_path / "out" / "a.mp4", fps=30, size=SIZE)
    sink.open()
    for index in range(20):
        sink.write(Frame(index, 0.0, {}), patches())
    sink.abort()
    sink.abort()
    assert list(tmp_path.iterdir()) == []


def test_unknown_ending_is_a_usage_error(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"\.mp4, \.webm, \.gif"):
        VideoSink(tmp_path / "a.avi", fps=30, size=SIZE)


@pytest.fixture
def failing_encoder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An ffmpeg that reads a little, complains and gives up."""
    script = tmp_path / "ffmpeg"
    script.write_text("#!/bin/sh\nhead -c 100000 > /dev/null\necho 'no space left, alas' >&2\nexit 7\n")
    script.chmod(script.stat().st_mode | stat.S_IEXEC)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", os.fspath(script))


def write_for_ever(sink: VideoSink) -> None:
    for index in itertools.count():
        sink.write(Frame(index, 0.0, {}), patches())


@pytest.mark.usefixtures("failing_encoder")
def test_encoder_that_fails_midway_is_an_output_error_with_its_last_words(tmp_path: Path) -> None:
    sink = VideoSink(tmp_path / "out" / "a.mp4", fps=30, size=SIZE)
    sink.open()
    with pytest.raises(OutputError, match=r"(?s)exit code 7.*no space left, alas"):
        write_for_ever(sink)
    sink.abort()
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("failing_encoder")
def test_encoder_that_fails_at_the_end_leaves_no_video(tmp_path: Path) -> None:
    sink = VideoSink(tmp_path / "out" / "a.mp4", fps=30, size=SIZE)
    sink.open()
    sink.write(Frame(0, 0.0, {}), patches())
    with pytest.raises(OutputError, match="exit code 7"):
        sink.close()
    sink.abort()
    assert not (tmp_path / "out").exists()


def test_missing_encoder_is_an_output_error_before_any_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", os.fspath(tmp_path / "nothing"))
    with pytest.raises(OutputError, match="cannot start the video encoder"):
        VideoSink(tmp_path / "out" / "a.mp4", fps=30, size=SIZE).open()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "getpriority"), reason="this system has no priorities to set")
def test_the_encoder_yields_to_the_run(tmp_path: Path) -> None:
    pictures = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", "16x16", "-r", "1", "-i", "-"]
    encoder = Encoder(pictures, tmp_path / "video.mp4")
    try:
        assert os.getpriority(os.PRIO_PROCESS, encoder._process.pid) >= 15
    finally:
        encoder.kill()

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from PIL import Image as Pillow

from particlecli.errors import OutputError
from particlecli.frame import Frame
from particlecli.sinks import png
from particlecli.sinks.images import ImagesSink

Frames = Callable[[int], list[Frame]]


@given(arrays.arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9), st.just(3))))
def test_png_reads_back_exactly(image: np.ndarray) -> None:
    read = Pillow.open(io.BytesIO(png.encode(image)))
    assert read.mode == "RGB"
    assert np.array_equal(np.asarray(read), image)


def test_frames_are_exact_though_the_buffer_is_reused(tmp_path: Path, empty_frames: Frames) -> None:
    sink = ImagesSink(tmp_path / "frames")
    sink.open()
    buffer = np.zeros((20, 30, 3), np.uint8)
    for frame in empty_frames(12):
        buffer[:] = frame.index * 20
        sink.write(frame, buffer)
        assert not (tmp_path / "frames").exists()
    sink.close()
    names = sorted(path.name for path in (tmp_path / "frames").iterdir())
    assert names == [f"frame_{index:05d}.png" for index in range(12)]
    assert sink.files == (tmp_path / "frames",)
    for index, name in enumerate(names):
        assert np.all(np.asarray(Pillow.open(tmp_path / "frames" / name)) == index * 20)


def test_fewer_frames_replace_more(tmp_path: Path, empty_frames: Frames) -> None:
    for count in (5, 2):
        sink = ImagesSink(tmp_path / "frames")
        sink.open()
        for frame in empty_frames(count):
            sink.write(frame, np.zeros((4, 4, 3), np.uint8))
        sink.close()
    assert len(list((tmp_path / "frames").iterdir())) == 2


def test_folder_with_other_things_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "frames").mkdir()
    (tmp_path / "frames" / "thesis.tex").touch()
    with pytest.raises(OutputError, match=r"thesis\.tex"):
        ImagesSink(tmp_path / "frames").open()


def test_aborted_frames_leave_nothing(tmp_path: Path, empty_frames: Frames) -> None:
    sink = ImagesSink(tmp_path / "frames")
    sink.open()
    for frame in empty_frames(20):
        sink.write(frame, np.zeros((4, 4, 3), np.uint8))
    sink.abort()
    sink.abort()
    assert list(tmp_path.iterdir()) == []


def test_picture_that_cannot_be_written_is_an_output_error(tmp_path: Path, empty_frames: Frames) -> None:
    sink = ImagesSink(tmp_path / "frames")
    sink.open()
    for entry in tmp_path.iterdir():
        entry.rmdir()
    sink.write(empty_frames(1)[0], np.zeros((4, 4, 3), np.uint8))
    with pytest.raises(OutputError, match="cannot write"):
        sink.close()
    sink.abort()

"""Files that are no whole recordings of the Rerun in use."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import rerun as rr

from particlecli.errors import UsageError
from particlecli.frame import Frame
from particlecli.sinks.recording.reader import Recording
from tests.sinks.recording.conftest import Record


def version(major: int, minor: int) -> Callable[[bytes], bytes]:
    return lambda whole: whole[:4] + bytes([major, minor, 0, 0]) + whole[8:]


def scratched(whole: bytes) -> bytes:
    begin, end = len(whole) // 4, len(whole) * 3 // 4
    return whole[:begin] + b"\xff" * (end - begin) + whole[end:]


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda _: b"", "not a Rerun recording"),
        (lambda _: b"title: a scene\n" * 10, "not a Rerun recording"),
        (lambda whole: whole[:6], "nothing of the recording is left"),
        (lambda whole: b"RRF1" + whole[4:], "old Rerun version"),
        (version(0, 20), "written by Rerun 0.20.0"),
        (version(0, 99), "written by Rerun 0.99.0"),
        (lambda whole: whole[:-1000], "cut short.*--partial"),
        (scratched, "damaged"),
    ],
)
def test_one_clear_message(
    record: Record, frames: list[Frame], tmp_path: Path, damage: Callable[[bytes], bytes], says: str
) -> None:
    path = tmp_path / "b.rrd"
    path.write_bytes(damage(record("a.rrd", frames).read_bytes()))
    with pytest.raises(UsageError, match=says) as caught, Recording(path) as recording:
        list(recording.points("dust"))
    assert "\n" not in str(caught.value)


def test_a_single_bit_of_a_position_is_missed(record: Record, frames: list[Frame], tmp_path: Path) -> None:
    """Rerun's own format has no checksums: it reads other numbers, and says nothing."""
    whole = record("a.rrd", frames).read_bytes()
    with Recording(tmp_path / "a.rrd") as recording:
        positions = next(each.positions for each in recording.points("dust") if len(each.positions))
    place = whole.index(positions[0].tobytes()) + 1
    path = tmp_path / "b.rrd"
    path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
    with pytest.raises(UsageError, match=r"damaged: frame \d is not what was written"), Recording(path) as recording:
        list(recording.points("dust"))


def test_missing_file_and_folder(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no such file"):
        Recording(tmp_path / "a.rrd")
    with pytest.raises(UsageError, match="is a folder"):
        Recording(tmp_path)


def test_recording_of_something_else(tmp_path: Path) -> None:
    stream = rr.RecordingStream("solar_system")
    stream.save(tmp_path / "a.rrd")
    stream.log("sun", rr.Points3D([[0, 0, 0]]), static=True)
    stream.disconnect()
    with pytest.raises(UsageError, match="solar_system wrote it"):
        Recording(tmp_path / "a.rrd")


@pytest.mark.parametrize("lost", [40, 1000, 5000])
def test_what_is_there_of_a_cut_one_can_be_read(record: Record, frames: list[Frame], tmp_path: Path, lost: int) -> None:
    path = tmp_path / "b.rrd"
    path.write_bytes(record("a.rrd", frames).read_bytes()[:-lost])
    with Recording(path, partial=True) as recording:
        assert recording.title == "Two groups"


def test_nothing_can_be_left(record: Record, frames: list[Frame], tmp_path: Path) -> None:
    path = tmp_path / "b.rrd"
    path.write_bytes(record("a.rrd", frames).read_bytes()[:20])
    with pytest.raises(UsageError, match="nothing of the recording"):
        Recording(path, partial=True)

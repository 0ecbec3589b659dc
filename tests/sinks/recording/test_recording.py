"""What is recorded reads back, whatever becomes of the process and the disk."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rerun.chunk import RrdReader

from particlecli.errors import OutputError
from particlecli.frame import Frame
from particlecli.scene.load import load_scene
from particlecli.scene.model import Scene
from particlecli.sinks.recording.reader import Recording
from particlecli.sinks.recording.sink import RecordingSink
from tests.sinks.recording.conftest import Record


def test_points_read_back(record: Record, frames: list[Frame]) -> None:
    with Recording(record("a.rrd", frames)) as recording:
        assert (recording.title, recording.groups) == ("Two groups", ("dust", "sparks"))
        for name in recording.groups:
            found = list(recording.points(name))
            assert [points.frame for points in found] == [0, 1, 2, 3]
            for points, frame in zip(found, frames, strict=True):
                group = frame.groups[name]
                assert points.time == pytest.approx(frame.time, abs=1e-9)
                assert np.array_equal(points.ids, group.ids)
                assert np.array_equal(points.positions, group.positions.astype(np.float32))


def test_colours_are_those_of_the_look(record: Record, frames: list[Frame]) -> None:
    with Recording(record("a.rrd", frames)) as recording:
        assert [points.colors.tolist() for points in recording.points("dust")] == [[0xFF0000FF]] * 4
        for points in recording.points("sparks"):
            black, grey, white = points.colors.tolist()
            assert (black, white) == (0x000000FF, 0xFFFFFFFF)
            assert black < grey < white


def test_what_does_not_change_is_written_once(record: Record, frames: list[Frame]) -> None:
    path = record("a.rrd", frames)
    columns = {"ids": 1, "Points3D:positions": 4, "Points3D:colors": 0, "Points3D:class_ids": 0}
    assert {name: len(column(path, "/particles/dust", name)) for name in columns} == columns
    assert len(column(path, "/particles/sparks", "Points3D:class_ids")) == 1


def test_series_scene_report_and_data_files_read_back(
    record: Record, frames: list[Frame], scene: Scene, tmp_path: Path
) -> None:
    with Recording(record("a.rrd", frames)) as recording:
        kinetic = recording.series["energy/kinetic"]
        assert kinetic.values.tolist() == [0, 1 / 3, 2 / 3, 1]
        assert kinetic.frames.tolist() == [0, 1, 2, 3]
        assert recording.series["deaths/sparks/expired"].values.tolist() == [0, 1, 2, 3]
        error = recording.series["error/dust"]
        assert (error.frames.tolist(), error.values.tolist()) == ([1, 3], [1e-6, 3e-6])
        assert recording.report == '{"frames": 4}'
        assert recording.attachments == {"files/dust.csv": (scene.folder / "dust.csv").read_bytes()}
        (tmp_path / "again.yaml").write_text(recording.scene)
        (tmp_path / "files").mkdir()
        (tmp_path / "files" / "dust.csv").write_bytes(recording.attachments["files/dust.csv"])
    again = load_scene(tmp_path / "again.yaml")
    assert again.particles["dust"].file == "files/dust.csv"
    assert again.emitters == scene.emitters


def test_radii_planes_and_layout_are_there(record: Record, frames: list[Frame]) -> None:
    reader = RrdReader(record("a.rrd", frames))
    assert len(reader.blueprints()) == 1
    static = {
        (str(chunk.entity_path), name): chunk.to_record_batch().column(name).values.to_pylist()
        for chunk in reader.stream().filter(is_static=True).to_chunks()
        for name in chunk.to_record_batch().schema.names
        if ":" in name
    }
    assert static["/particles/dust", "Points3D:radii"] == [0.5]
    assert static["/particles/sparks", "Points3D:radii"] == [-3]
    corners = np.array(static["/planes/0", "Mesh3D:vertex_positions"])
    normal = np.array(static["/planes/0/normal", "Arrows3D:vectors"][0])
    assert np.allclose(corners @ [0, 0.6, 0.8], 0, atol=1e-5)
    assert np.allclose(normal / np.linalg.norm(normal), [0, 0.6, 0.8])
    carried = np.array(static["/frames/base/tip/planes/1", "Mesh3D:vertex_positions"])
    assert np.allclose(carried[:, 0], 0.5)
    assert np.allclose(2 * np.ptp(carried, axis=0)[1:], np.ptp(corners, axis=0)[0])  # the frame's scale


def column(path: Path, entity: str, name: str) -> list[list[object]]:
    """What a column holds at each frame."""
    chunks = RrdReader(path).stream().filter(content=entity, components=name, is_static=False).to_chunks()
    return [row for chunk in chunks for row in chunk.to_record_batch().column(name).to_pylist()]


def test_springs_whose_ends_live_are_strips(record: Record, frames: list[Frame]) -> None:
    strips = column(record("a.rrd", frames), "/springs/sparks", "LineStrips3D:strips")
    assert [len(each) for each in strips] == [1, 2, 1, 0]
    begin, end = frames[1].groups["sparks"].positions[1:3]
    assert np.allclose(strips[1][0], [begin, end])


def test_coordinate_frames_are_below_the_ones_they_ride_on(record: Record, frames: list[Frame]) -> None:
    path = record("a.rrd", frames)
    turns = column(path, "/frames/base", "Transform3D:quaternion")
    assert np.allclose(np.ravel(turns)[[1, 3, 5, 7]], [0, 1, np.sin(0.5), np.cos(0.5)])
    assert np.allclose(column(path, "/frames/base/tip", "Transform3D:translation"), [[[1, i, 0]] for i in range(4)])
    assert column(path, "/frames/base/tip", "Transform3D:scale") == [[[2, 2, 2]]]


def test_every_second_frame_and_not_too_many_points(record: Record, frames: list[Frame]) -> None:
    with Recording(record("a.rrd", frames, every=2, max_points=50)) as recording:
        assert [points.frame for points in recording.points("dust")] == [0, 2]
        for dust, sparks in zip(recording.points("dust"), recording.points("sparks"), strict=True):
            assert (len(dust.ids), len(sparks.ids)) == (100 * 50 // 103, 3 * 50 // 103)
            whole = frames[dust.frame].groups["dust"]
            assert np.array_equal(dust.positions, whole.positions[dust.ids])
            assert len(sparks.colors) == 1


def test_a_finished_recording_is_all_that_is_left(record: Record, frames: list[Frame], tmp_path: Path) -> None:
    record("out/a.rrd", frames)
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["a.rrd"]


def test_aborted_recording_leaves_nothing(scene: Scene, frames: list[Frame], tmp_path: Path) -> None:
    sink = RecordingSink(tmp_path / "out" / "a.rrd", scene)
    sink.abort()
    sink.open()
    sink.write(frames[0], None)
    sink.abort()
    sink.abort()
    assert not (tmp_path / "out").exists()


PROCESS = """\
import os, signal, time
from pathlib import Path
import numpy as np
from particlecli.frame import Frame, GroupFrame
from particlecli.scene.model import Scene
from particlecli.sinks.recording.sink import RecordingSink

scene = Scene.model_validate({"duration": 1, "particles": {"dust": {"positions": [[0, 0, 0]]}}})
sink = RecordingSink(Path("a.rrd"), scene)
sink.open()
noise = np.random.default_rng(0).random((9000, 3), np.float32)  # which does not compress
def write(count):
    for index in range(count):
        group = GroupFrame(np.arange(9000), index + noise)
        sink.write(Frame(index, index / 30, {"dust": group}, {"alive": {"dust": 9000.0}}), None)
"""


def process(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", PROCESS + code]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=100, check=False)


def test_killed_process_leaves_a_readable_recording_under_its_temporary_name(tmp_path: Path) -> None:
    process("write(40); time.sleep(1); write(1); time.sleep(1); os.kill(os.getpid(), signal.SIGKILL)", tmp_path)
    (path,) = tmp_path.iterdir()
    assert path.name.endswith(".partial.rrd")
    assert not path.name.startswith(".")
    with Recording(path) as recording:
        frames = [(points.frame, points.positions) for points in recording.points("dust")]
        assert recording.report is None
        assert "dust" in recording.scene
    assert len(frames) >= 40
    assert all((np.floor(positions) == frame).all() for frame, positions in frames)


def test_process_killed_at_once_leaves_the_scene(tmp_path: Path) -> None:
    process("os.kill(os.getpid(), signal.SIGKILL)", tmp_path)
    (path,) = tmp_path.iterdir()
    with Recording(path) as recording:
        assert "dust" in recording.scene
        assert list(recording.points("dust")) == []


def test_full_disk_is_an_output_error(
    scene: Scene, frames: list[Frame], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sink = RecordingSink(tmp_path / "out" / "a.rrd", scene)
    sink.open()
    sink.write(frames[0], None)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=5 << 20))
    with pytest.raises(OutputError, match=r"disk is full \(5 MB"):
        sink.close()
    sink.abort()
    assert not (tmp_path / "out").exists()


def test_folder_that_cannot_be_written_is_found_out_when_opening(scene: Scene, tmp_path: Path) -> None:
    (tmp_path / "out").touch()
    with pytest.raises(OutputError, match="cannot write"):
        RecordingSink(tmp_path / "out" / "a.rrd", scene).open()

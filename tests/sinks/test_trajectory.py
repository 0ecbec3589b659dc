from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from particlecli.errors import UsageError
from particlecli.frame import Frame, GroupFrame
from particlecli.sinks.trajectory import TrajectorySink


def write(path: Path, frames: list[Frame], every: int = 1) -> None:
    sink = TrajectorySink(path, every=every)
    assert sink.needs("sparks") == {"velocities", "temperatures"}
    sink.open()
    for frame in frames:
        sink.write(frame, None)
        assert not path.exists()
    sink.close()
    assert sink.files == (path,)


def test_npz_reads_back_exactly(tmp_path: Path, particle_frames: list[Frame]) -> None:
    write(tmp_path / "a.npz", particle_frames)
    with np.load(tmp_path / "a.npz") as table:
        assert list(table["groups"]) == ["sparks", "smoke"]
        assert len(table["id"]) == sum(frame.alive for frame in particle_frames)
        for frame in particle_frames:
            for index, group in enumerate(frame.groups.values()):
                rows = (table["frame"] == frame.index) & (table["group"] == index)
                assert np.all(table["time"][rows] == frame.time)
                assert np.array_equal(table["id"][rows], group.ids)
                assert np.array_equal(table["position"][rows], group.positions)
                for column, values in (("velocity", group.velocities), ("temperature", group.temperatures)):
                    if values is None:
                        assert np.isnan(table[column][rows]).all()
                    else:
                        assert np.array_equal(table[column][rows], values)
        assert table["position"].dtype == np.float32
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.npz"]


def test_csv_reads_back_exactly(tmp_path: Path, particle_frames: list[Frame]) -> None:
    write(tmp_path / "a.npz", particle_frames)
    write(tmp_path / "a.csv", particle_frames)
    with (tmp_path / "a.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["time", "frame", "group", "id", "x", "y", "z", "vx", "vy", "vz", "temperature"]

    def numbers(*titles: str) -> np.ndarray:
        return np.array([[np.float32(row[title] or "nan") for title in titles] for row in rows]).squeeze()

    with np.load(tmp_path / "a.npz") as table:
        assert [float(row["time"]) for row in rows] == table["time"].tolist()
        assert [row["group"] for row in rows] == table["groups"][table["group"]].tolist()
        assert [int(row["id"]) for row in rows] == table["id"].tolist()
        assert np.array_equal(numbers("x", "y", "z"), table["position"])
        assert np.array_equal(numbers("vx", "vy", "vz"), table["velocity"], equal_nan=True)
        assert np.array_equal(numbers("temperature"), table["temperature"], equal_nan=True)


def test_double_precision_is_kept(tmp_path: Path) -> None:
    positions = np.array([[1 / 3, 1e-300, -0.1]])
    frame = Frame(0, 0.0, {"a": GroupFrame(np.array([2**40]), positions)})
    write(tmp_path / "a.npz", [frame])
    write(tmp_path / "a.csv", [frame])
    with np.load(tmp_path / "a.npz") as table:
        assert np.array_equal(table["position"], positions)
    assert (tmp_path / "a.csv").read_text().splitlines()[1] == f"0.0,0,a,{2**40},{1 / 3},1e-300,-0.1"


def test_columns_nobody_has_are_left_out(tmp_path: Path) -> None:
    frame = Frame(0, 0.0, {"a": GroupFrame(np.arange(1), np.zeros((1, 3)))})
    write(tmp_path / "a.npz", [frame])
    write(tmp_path / "a.csv", [frame])
    with np.load(tmp_path / "a.npz") as table:
        assert "velocity" not in table
        assert "temperature" not in table
    assert (tmp_path / "a.csv").read_text().splitlines()[0] == "time,frame,group,id,x,y,z"


@pytest.mark.parametrize("ending", ["npz", "csv"])
def test_same_frames_same_bytes(tmp_path: Path, particle_frames: list[Frame], ending: str) -> None:
    for name in "ab":
        write(tmp_path / f"{name}.{ending}", particle_frames)
    assert (tmp_path / f"a.{ending}").read_bytes() == (tmp_path / f"b.{ending}").read_bytes()


def test_every_second_frame(tmp_path: Path, particle_frames: list[Frame]) -> None:
    write(tmp_path / "a.npz", particle_frames, every=2)
    with np.load(tmp_path / "a.npz") as table:
        assert set(table["frame"].tolist()) == {0, 2}


@pytest.mark.parametrize("ending", ["npz", "csv"])
def test_scene_without_groups_makes_an_empty_table(tmp_path: Path, ending: str) -> None:
    write(tmp_path / f"a.{ending}", [Frame(0, 0.0, {})])
    assert (tmp_path / f"a.{ending}").stat().st_size > 0


@pytest.mark.parametrize("ending", ["npz", "csv"])
def test_aborted_trajectory_leaves_nothing(tmp_path: Path, particle_frames: list[Frame], ending: str) -> None:
    sink = TrajectorySink(tmp_path / "out" / f"a.{ending}")
    sink.open()
    sink.write(particle_frames[2], None)
    sink.abort()
    sink.abort()
    assert list(tmp_path.iterdir()) == []


def test_unknown_ending_is_a_usage_error(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"\.npz, \.csv"):
        TrajectorySink(tmp_path / "a.txt")

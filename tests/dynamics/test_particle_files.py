"""Particle files: what is read, and what is said about those that cannot be."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from particlecli.dynamics.particle_files import ParticleList, read_particles
from particlecli.errors import SceneError

KEY = "particles.bodies.file"


def read(folder: Path, name: str, content: str | bytes) -> ParticleList:
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_particles(Path(name), folder, KEY)


def archive(**arrays: Any) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def complaint(folder: Path, name: str, content: str | bytes | None = None) -> str:
    with pytest.raises(SceneError) as caught:
        read(folder, name, content) if content is not None else read_particles(Path(name), folder, KEY)
    [problem] = caught.value.problems
    assert problem.key == KEY
    assert problem.message.startswith(f"`{name}`: ")
    return problem.message


def test_a_table_s_columns_may_stand_in_any_order(tmp_path: Path) -> None:
    table = "mass,z, y ,x,vz,vy,vx,temperature\n1e-3,3,2,1,6,5,4,300\n2,-3,-2,-1,-6,-5,-4,1e3\n"
    particles = read(tmp_path, "bodies.csv", table)
    assert particles.positions.tolist() == [[1, -1], [2, -2], [3, -3]]
    assert particles.velocities.tolist() == [[4, -4], [5, -5], [6, -6]]
    assert particles.masses.tolist() == [1e-3, 2]
    assert particles.temperatures.tolist() == [300, 1000]


def test_a_table_of_positions_alone_gives_nothing_else(tmp_path: Path) -> None:
    particles = read(tmp_path, "bodies.csv", "x,y,z\n1,2,3\n")
    assert len(particles) == 1
    assert particles.velocities is particles.masses is particles.temperatures is None


@pytest.mark.parametrize(
    "table",
    [
        "\ufeffx,y,z\n1,2,3\n4,5,6",
        "x,y,z\r\n1,2,3\r\n4,5,6\r\n",
        "\n\nx,y,z\n\n1,2,3\n\n4,5,6\n\n",
        '"x","y","z"\n"1",2,3\n4,5,6\n',
        "x, y, z\n 1 , 2 , 3 \n4,5,6\n",
    ],
    ids=["byte order mark", "windows lines", "blank lines", "quotes", "spaces"],
)
def test_tables_as_spreadsheets_write_them(tmp_path: Path, table: str) -> None:
    assert read(tmp_path, "bodies.csv", table).positions.T.tolist() == [[1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("", "is empty; its first line names the columns: x, y, z, vx"),
        ("x,y,z\n", "holds no particles"),
        ("x,y\n1,2\n", "column `z` is missing; x, y, z belong together"),
        ("x,y,z,vx\n1,2,3,4\n", "column `vy` is missing; x, y, z, vx, vy, vz belong together"),
        ("x,y,z,masss\n1,2,3,4\n", "unknown column `masss`; did you mean `mass`? Known are x, y, z"),
        ("x,y,z,colour\n1,2,3,4\n", "unknown column `colour`; Known are"),
        ("x,y,z,x\n1,2,3,4\n", "column `x` is there twice"),
        ("1,2,3\n4,5,6\n", "unknown column `1`"),
        ("x,y,z\n1,2,3\n\n4,5\n", "line 4 has 2 values under 3 column names"),
        ("x,y,z\n1,2,3,4\n5,6,7,8\n", "line 2 has 4 values under 3 column names"),
        ("x,y,z\n1,2,3\n4,five,6\n", "line 3, column y: `five` is not a number"),
        ("x,y,z\n1,2,3\n4,,6\n", "line 3, column y: there is no value"),
        ("x,y,z\n1,2,3\n\n\n4,nan,6\n", "line 5, column y: `nan` is not finite"),
        ("x,y,z\n1,2,3\n4,5,-inf\n", "line 3, column z: `-inf` is not finite"),
        ("x,y,z\n1,2,1e999\n", "line 2, column z: `1e999` is not finite"),
        ("x,y,z,mass\n1,2,3,1\n1,2,3,-1\n", "line 3, column mass: `-1` is not positive"),
        ("x,y,z,temperature\n1,2,3,0\n", "line 2, column temperature: `0` is not positive"),
        (b"\x89PNG\r\n\x1a\n\x00\xff\xfe", "is not a text file"),
    ],
)
def test_bad_tables_are_refused_with_their_first_fault(tmp_path: Path, table: str | bytes, message: str) -> None:
    assert message in complaint(tmp_path, "bodies.csv", table)


def test_an_archive_gives_what_it_holds(tmp_path: Path) -> None:
    positions = np.arange(12, dtype=np.float32).reshape(4, 3)
    content = archive(positions=positions, velocities=-positions, masses=[1, 2, 3, 4], temperatures=[9.5] * 4)
    particles = read(tmp_path, "bodies.npz", content)
    assert particles.positions.dtype == np.float64
    assert particles.positions.flags.c_contiguous
    assert np.array_equal(particles.positions, positions.T)
    assert np.array_equal(particles.velocities, -positions.T)
    assert particles.masses.tolist() == [1, 2, 3, 4]
    assert particles.temperatures.tolist() == [9.5] * 4


TWO = np.zeros((2, 3))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is not an archive of arrays of numbers"),
        (b"no archive", "is not an archive of arrays of numbers"),
        (archive(positions=TWO)[:60], "is not an archive of arrays of numbers"),
        (archive(velocities=TWO), "has no array `positions`"),
        (archive(positions=TWO, position=TWO), "unknown array `position`; did you mean `positions`?"),
        (archive(positions=np.zeros((0, 3))), "holds no particles"),
        (archive(positions=np.zeros((2, 2))), "`positions` has shape (2, 2) instead of (n, 3)"),
        (archive(positions=np.float64(1)), "`positions` has shape () instead of (n, 3)"),
        (archive(positions=TWO, masses=[1.0]), "`masses` has shape (1,) instead of (2,)"),
        (archive(positions=TWO, masses=[1.0, -1.0]), "`masses` is not positive in row 1: -1.0"),
        (archive(positions=TWO, masses=[np.nan, 1.0]), "`masses` is not finite in row 0: nan"),
        (archive(positions=TWO, temperatures=[0, 1]), "`temperatures` is not positive in row 0: 0"),
        (archive(positions=[[0, 0, 0], [1, np.inf, 0]]), "`positions` is not finite in row 1: [ 1. inf  0.]"),
        (archive(positions=TWO.astype(complex)), "`positions` holds complex128 instead of numbers"),
        (archive(positions=TWO.astype(str)), "instead of numbers"),
        (archive(positions=np.array([[None] * 3])), "is not an archive of arrays of numbers"),
    ],
)
def test_bad_archives_are_refused(tmp_path: Path, content: bytes, message: str) -> None:
    assert message in complaint(tmp_path, "bodies.npz", content)


def test_a_single_array_is_no_archive(tmp_path: Path) -> None:
    buffer = io.BytesIO()
    np.save(buffer, TWO)
    assert "is not an archive of arrays of numbers" in complaint(tmp_path, "bodies.npz", buffer.getvalue())


def test_files_that_cannot_be_read_at_all(tmp_path: Path) -> None:
    assert "there is no such file" in complaint(tmp_path, "missing.csv")
    assert "must end in .csv or .npz" in complaint(tmp_path, "bodies.txt", "x,y,z\n1,2,3\n")
    (tmp_path / "folder.csv").mkdir()
    assert "irectory" in complaint(tmp_path, "folder.csv")


def test_only_files_of_the_scene_s_folder_are_read(tmp_path: Path) -> None:
    scene, outside = tmp_path / "scene", tmp_path / "outside.csv"
    scene.mkdir()
    outside.write_text("x,y,z\n1,2,3\n")
    (scene / "link.csv").symlink_to(outside)
    for name in ("../outside.csv", str(outside), "link.csv"):
        assert "outside the scene's folder" in complaint(scene, name)

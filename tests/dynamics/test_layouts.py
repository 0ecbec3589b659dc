"""Layouts, and what a group lists against what its file gives."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pydantic import ValidationError
from scipy import stats

from particlecli.dynamics.layouts import arrangement, layout_count, layout_positions
from particlecli.dynamics.particle_files import ParticleList
from particlecli.dynamics.random import Draws
from particlecli.errors import SceneError
from particlecli.scene.groups import Particles


def positions(**layout: Any) -> NDArray[np.float64]:
    """All positions of a layout, one a row."""
    parsed = Particles.model_validate({"layout": layout}).layout
    assert parsed is not None
    return layout_positions(parsed, Draws(7, "bodies", np.arange(layout_count(parsed)))).T


def test_a_grid_runs_along_x_first_and_lies_about_its_center() -> None:
    grid = positions(type="grid", center=[1, 2, 3], counts=[3, 2, 1], spacing=[1, 10, 100])
    assert grid.tolist() == [[0, -3, 3], [1, -3, 3], [2, -3, 3], [0, 7, 3], [1, 7, 3], [2, 7, 3]]


def test_a_grid_with_one_spacing_is_cubic() -> None:
    cube = positions(type="grid", counts=[2, 2, 2], spacing=0.5)
    assert len(np.unique(cube, axis=0)) == 8
    assert (np.abs(cube) == 0.25).all()


def test_a_line_has_both_its_ends() -> None:
    line = positions(type="line", start=[0, 0, 1], end=[3, 0, -1], count=3)
    assert line.tolist() == [[0, 0, 1], [1.5, 0, 0], [3, 0, -1]]


def test_a_ball_and_a_box_are_filled_evenly() -> None:
    ball = positions(type="ball", center=[5, 0, 0], radius=2, count=5000) - [5, 0, 0]
    assert stats.kstest((np.linalg.norm(ball, axis=1) / 2) ** 3, "uniform").pvalue > 1e-3
    box = positions(type="box", center=[0, 1, 0], size=[1, 2, 4], count=5000)
    for axis, (low, size) in enumerate([(-0.5, 1), (0, 2), (-2, 4)]):
        assert stats.kstest(box[:, axis], "uniform", args=(low, size)).pvalue > 1e-3


def on_lattice(**lattice: Any) -> NDArray[np.float64]:
    group = Particles.model_validate({"layout": {"type": "lattice", **lattice}})
    listed = arrangement("bodies", group, Path())
    assert isinstance(listed, ParticleList)
    return listed.positions.T


def test_a_lattice_fills_its_box_with_cells() -> None:
    lattice = on_lattice(center=[1, 2, 3], size=[3, 2.5, 0], spacing=[1, 1.2, 7])
    assert lattice.tolist() == [[x, y, 3] for y in (1.375, 2.625) for x in (0, 1, 2)]
    assert len(on_lattice(size=[1, 2, 3], spacing=0.5)) == 2 * 4 * 6


def test_a_hexagonal_lattice_has_six_neighbours_at_one_distance() -> None:
    spacing = 0.1
    lattice = on_lattice(size=[2, 20 * math.sqrt(0.75) * spacing, 0], spacing=spacing, pattern="hexagonal")
    assert len(lattice) == 400
    middle = np.argmin(np.linalg.norm(lattice, axis=1))
    assert np.sort(np.linalg.norm(lattice - lattice[middle], axis=1))[1:7] == pytest.approx(spacing)


def test_a_lattice_is_cut_to_where_a_condition_holds() -> None:
    square = {"size": [2, 2, 0], "spacing": 0.01}
    for where in ("x**2 + y**2 < 1", "1 - x**2 - y**2"):
        disc = on_lattice(**square, where=where)
        assert (np.linalg.norm(disc, axis=1) < 1).all()
        assert len(disc) * 1e-4 == pytest.approx(math.pi, rel=1e-3)
    assert len(on_lattice(**square, where=1)) == 40_000
    with pytest.raises(SceneError, match="holds nowhere"):
        on_lattice(**square, where="x > 5")
    with pytest.raises(ValidationError, match="at most 2e"):
        on_lattice(size=[1, 1, 1], spacing=1e-6)


def test_a_group_has_its_list_or_its_file_or_its_layout(tmp_path: Path) -> None:
    (tmp_path / "two.csv").write_text("x,y,z\n1,2,3\n4,5,6\n")
    listed = arrangement("bodies", Particles(positions=((1, 2, 3), (4, 5, 6))), tmp_path)
    read = arrangement("bodies", Particles(file="two.csv"), tmp_path)
    assert isinstance(listed, ParticleList)
    assert isinstance(read, ParticleList)
    assert listed.positions.tolist() == read.positions.tolist() == [[1, 4], [2, 5], [3, 6]]
    assert len(listed) == len(read) == 2
    group = Particles.model_validate({"layout": {"type": "box", "size": [1, 1, 1], "count": 3}})
    assert arrangement("bodies", group, tmp_path) is group.layout


@pytest.mark.parametrize(
    ("column", "given"),
    [("vx,vy,vz", {"velocity": [0, 0, 1]}), ("mass", {"mass": 2}), ("temperature", {"temperature": 300})],
)
def test_what_the_file_gives_must_not_be_given_again(tmp_path: Path, column: str, given: dict[str, Any]) -> None:
    values = ",".join("5" for _ in column.split(","))
    (tmp_path / "all.csv").write_text(f"x,y,z,{column}\n0,0,0,{values}\n")
    group = Particles.model_validate({"file": "all.csv", **given})
    with pytest.raises(SceneError) as caught:
        arrangement("bodies", group, tmp_path)
    assert [problem.key for problem in caught.value.problems] == [f"particles.bodies.{next(iter(given))}"]


def test_defaults_written_out_do_not_count_as_given_again(tmp_path: Path) -> None:
    (tmp_path / "all.csv").write_text("x,y,z,mass\n0,0,0,5\n")
    resolved = Particles.model_validate(Particles(file="all.csv").model_dump())
    assert isinstance(arrangement("bodies", resolved, tmp_path), ParticleList)

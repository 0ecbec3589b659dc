# ruff: noqa: E501 - a table of cases reads best with one line for each

from pathlib import Path

import pytest

from particlecli.errors import SceneError
from particlecli.scene.known_answers import Absolute, Relative
from particlecli.scene.load import dump_scene, load_scene

BASE = """\
duration: 1
particles: {p: {positions: [[0, 0, 0]]}}
reference:
"""


def load(folder: Path, *answers: str):
    file = folder / "scene.yaml"
    file.write_text(BASE + "".join(f"  - {{at: 1, group: p, {answer}}}\n" for answer in answers))
    return load_scene(file)


def test_a_plain_number_is_an_absolute_tolerance(tmp_path: Path) -> None:
    scene = load(tmp_path, "energy: -0.5, tolerance: 1e-9", "position: [1, 2, 3], tolerance: {relative: 0.01}")
    first, second = scene.reference
    assert first.tolerance == Absolute(absolute=1e-9)
    assert second.tolerance == Relative(relative=0.01)
    (tmp_path / "again.yaml").write_text(dump_scene(scene))
    assert load_scene(tmp_path / "again.yaml") == scene


@pytest.mark.parametrize(
    ("answer", "column", "key", "message"),
    [
        ("tolerance: 1", 5, "", "what is known? Give `position`"),
        ("position: [0, 0, 0]", 5, ".tolerance", "is missing: largest error that passes"),
        ("position: [0, 0, 0], tolerance: 0", 55, ".tolerance", "must be positive, and is 0"),
        ("position: [0, 0, 0], tolerance: {part: 1}", 56, ".tolerance.part", "unknown key; known here: absolute, relative"),
        ("position: [0, 0], tolerance: 1", 33, ".position", "must be 3 numbers, not 2"),
        ("positions: [], tolerance: 1", 34, ".positions", "must not be empty"),
        ("position: [1, 1, 1], positions: [[1, 1, 1]], tolerance: 1", 55, ".positions", "give `position` or `positions`"),
        ("velocity: [1, 1, 1], velocities: [[1, 1, 1]], tolerance: 1", 56, ".velocities", "give `velocity` or"),
        ("particles: [-1], energy: 1, tolerance: 1", 35, ".particles[0]", "must not be negative, and is -1"),
        ("quantity: speed, tolerance: 1", 33, ".quantity", "give `quantity` and `value` together"),
        ("value: 1, tolerance: 1", 30, ".value", "give `quantity` and `value` together"),
        ("quantity: x*m, value: 1, tolerance: 1", 33, ".quantity", "unknown name `m`"),
        ("velocity: [0, 0, 0], tolerance: {relative: 1}", 44, ".tolerance", "is relative to a known value that is zero"),
        ("energy: 1, of_all: max, tolerance: 1", 42, ".of_all", "goes with a `quantity`"),
        ("quantity: x, of_all: most, value: 1, tolerance: 1", 44, ".of_all", "min, max, mean, rms"),
        ("where: x > m, energy: 1, tolerance: 1", 30, ".where", "unknown name `m`"),
        ("where: density > 1, energy: 1, tolerance: 1", 30, ".where", "has no density: no force of type sph"),
        ("quantity: pressure, value: 1, tolerance: 1", 33, ".quantity", "has no pressure: no force of type sph"),
        ("energy: 0, tolerance: {relative: 1}", 34, ".tolerance", "is relative to a known value that is zero"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_told(tmp_path: Path, answer: str, column: int, key: str, message: str) -> None:
    with pytest.raises(SceneError) as caught:
        load(tmp_path, answer)
    found = caught.value.problems[0]
    assert message in found.message
    assert (found.line, found.column, found.key) == (4, column, f"reference[0]{key}")

from pathlib import Path

import pytest

from particlecli.errors import SceneError
from particlecli.scene.load import load_scene
from particlecli.scene.model import Scene

TEXT = """\
duration: 1
emitters:
  sparks: {rate: 10, speed: &speed {uniform: [1, 2]}}
  embers: {rate: 5, speed: *speed}
forces:
  - {type: gravity}
  - {type: drag, coefficient: 1}
planes:
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    file = tmp_path / "scene.yaml"
    file.write_text(TEXT.replace("planes:\n", ""))
    return file


def load(file: Path, *overrides: str) -> Scene:
    return load_scene(file, overrides)


def test_values_are_yaml(file: Path) -> None:
    scene = load(
        file,
        "integrator.dt=1e-2",
        "forces.1.coefficient=2",
        "forces[0].acceleration=[0, -1.62, 0]",
        "emitters.sparks.rate=50*t",
        "title=a = b",
        "look.groups.sparks={as: dots, pixels: 2}",
        " fps = 010 ",
    )
    assert scene.integrator.dt == 0.01
    assert scene.forces[1].coefficient == 2  # type: ignore[union-attr]
    assert scene.forces[0].acceleration == (0, -1.62, 0)  # type: ignore[union-attr]
    assert scene.emitters["sparks"].rate is not None
    assert scene.emitters["sparks"].rate.source == "50*t"
    assert scene.title == "a = b"
    assert scene.look.groups["sparks"].pixels == 2
    assert scene.fps == 10


def test_later_ones_win(file: Path) -> None:
    assert load(file, "fps=1", "fps=2").fps == 2


def test_whole_new_entries(file: Path) -> None:
    scene = load(file, "emitters.more={rate: 3}", "flows.wind=[]", "planes=[{restitution: 1}]", "planes.0.friction=2")
    assert "more" in scene.emitters
    assert scene.planes[0].friction.coulomb == 2  # type: ignore[union-attr]


def test_a_number_becomes_a_distribution(file: Path) -> None:
    assert load(file, "emitters.sparks.mass.uniform=[1, 2]").emitters["sparks"].mass.uniform == (1, 2)  # type: ignore[union-attr]


def test_aliases_elsewhere_keep_their_value(file: Path) -> None:
    scene = load(file, "emitters.sparks.speed.uniform.1=9")
    assert scene.emitters["sparks"].speed.uniform == (1, 9)  # type: ignore[union-attr]
    assert scene.emitters["embers"].speed.uniform == (1, 2)  # type: ignore[union-attr]


def test_null_takes_a_value_away(file: Path) -> None:
    assert load(file, "emitters.sparks.lifetime=3", "emitters.sparks.lifetime=").emitters["sparks"].lifetime is None


@pytest.mark.parametrize(
    ("override", "option", "key", "message"),
    [
        ("integrator.dt=0", "integrator.dt", "integrator.dt", "must be positive, and is 0"),
        ("integrator.dtt=1", "integrator.dtt", "integrator.dtt", 'unknown key; did you mean "dt"?'),
        ("integratr.dt=1", "integratr.dt", "integratr", 'unknown key; did you mean "integrator"?'),
        ("camera={position: 5}", "camera", "camera.position", "must be a list in square brackets"),
        ("emitters.sparkz.rate=1", "emitters.sparkz.rate", "emitters.sparkz.rate", 'did you mean "sparks"?'),
        ("particles.p.mass=1", "particles.p.mass", "particles.p.mass", 'there is no "p" in particles'),
        (
            "look.groups.sparkz.as=dots",
            "look.groups.sparkz.as",
            "look.groups.sparkz",
            'did you mean "sparks"?',
        ),
        ("forces.7.on=[]", "forces.7.on", "forces[7].on", "forces has 2 entries, counted from 0"),
        ("forces.drag.on=[]", "forces.drag.on", "forces.drag.on", "the next step must be a number below 2"),
        (
            "forces.0.acceleration.1=5",
            "forces.0.acceleration.1",
            "forces[0].acceleration[1]",
            "give the whole list",
        ),
        ("camera.position[0]=5", "camera.position[0]", "camera.position[0]", "give the whole list"),
        ("fps=[1", "fps", "", "this list is not closed"),
        ("fps={a: 1, a: 2}", "fps", "a", "stands here twice"),
        ("fps=*x", "fps", "", "there is no &x above"),
        ("fps=\0", "fps", "", "not a text file"),
        ("fps", "fps", "", "write it as key=value"),
        ("=3", "=3", "", "write it as key=value"),
        ("a..b=3", "a..b=3", "", "write it as key=value"),
        ("", "", "", "write it as key=value"),
    ],
)
def test_problems_name_the_option(file: Path, override: str, option: str, key: str, message: str) -> None:
    with pytest.raises(SceneError) as caught:
        load(file, override)
    (problem,) = caught.value.problems
    assert problem.option == f"--set {option}".strip() or problem.option == f"--set {option}"
    assert problem.key == key
    assert message in problem.message
    assert str(caught.value).startswith("--set")


def test_problems_in_the_file_come_first(file: Path) -> None:
    file.write_text(TEXT)
    with pytest.raises(SceneError) as caught:
        load(file, "fps=0", "duration=0")
    assert [(each.line, each.option) for each in caught.value.problems] == [
        (8, None),
        (None, "--set duration"),
        (None, "--set fps"),
    ]

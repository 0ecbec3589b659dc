import tempfile
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings

from particlecli.scene.checks import problems
from particlecli.scene.load import dump_scene, load_scene
from particlecli.scene.model import Scene
from tests.scene.strategies import Data, scenes


def reloaded(scene: Scene) -> Scene:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.yaml"
        file.write_text(dump_scene(scene), encoding="utf-8", newline="\n")
        return load_scene(file)


@given(scenes())
@settings(max_examples=150, deadline=None)
def test_reads_back_equal(data: Data) -> None:
    scene = Scene.model_validate(data)
    assert not problems(scene)
    again = reloaded(scene)
    assert again == scene
    assert dump_scene(again) == dump_scene(scene)


def test_says_everything() -> None:
    scene = Scene.model_validate({"duration": 2, "emitters": {"sparks": {"rate": 5}}})
    data = yaml.safe_load(dump_scene(scene))
    assert set(data) == {
        "title", "seed", "duration", "fps", "precision", "flows", "frames", "particles", "emitters", "forces",
        "planes", "integrator", "reference", "camera", "look", "outputs",
    }  # fmt: skip
    assert data["emitters"]["sparks"]["speed"] == 0
    assert data["camera"]["resolution"] == [1280, 720]


def test_is_good_to_read() -> None:
    scene = Scene.model_validate(
        {
            "title": "1e3",
            "duration": 2,
            "emitters": {"on": {"rate": "50*t", "speed": {"uniform": [1, 2]}, "mass": 1e-6}},
            "forces": [{"type": "gravity", "on": ["on"]}],
        }
    )
    text = dump_scene(scene)
    assert text.startswith("title: '1e3'\nseed: 0\nduration: 2.0\n")
    for line in (
        "  on:",
        "    rate: 50*t",
        "    speed: {uniform: [1.0, 2.0]}",
        "    mass: 1.0e-06",
        "forces: [{type: gravity, acceleration: [0.0, -9.80665, 0.0], on: [on]}]",
        "  resolution: [1280, 720]",
        "  background: '#05060a'",
    ):
        assert line in text.split("\n")
    assert max(map(len, text.split("\n"))) < 110
    assert "null" not in text


@pytest.mark.parametrize(
    "title", ["null", "true", "1", ".inf", "", "~", "é\u2028b", "a\tb", "\x07", "x" * 500, "a\n\nb "]
)
def test_texts_stay_texts(title: str) -> None:
    scene = Scene.model_validate({"title": title, "duration": 1, "emitters": {"e": {"rate": 1}}})
    assert reloaded(scene).title == title

"""Whatever stands in a file, it is a scene or a SceneError."""

import tempfile
from collections.abc import Sequence
from pathlib import Path

import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from particlecli.errors import SceneError
from particlecli.scene.load import dump_scene, load_scene
from particlecli.scene.model import Scene
from tests.scene.strategies import Data, scenes

FRAGMENTS = [
    *(
        ": ",
        "- ",
        "[",
        "]",
        "{",
        "}",
        ",",
        "&a ",
        "*a",
        "!!str ",
        "<<",
        "---\n",
        "\n",
        "  ",
        "\t",
        "#",
        "'",
        '"',
        "|",
    ),
    *(
        "null",
        "true",
        "yes",
        ".nan",
        "-.inf",
        "1e999",
        "-1",
        "0",
        "010",
        "x.y",
        "1/0",
        "open(x)",
        "type",
        "on",
        "é",
    ),
    *(
        "\0",
        ">",
        "? ",
        "[]",
        "{}",
        "[1, 2]",
        "blackbody",
        "first_order",
        "velocity_verlet",
        "/etc/passwd",
        "9" * 30,
    ),
]


def load(content: bytes, overrides: Sequence[str] = ()) -> Scene | None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.yaml"
        file.write_bytes(content)
        try:
            return load_scene(file, overrides)
        except SceneError as error:
            problems, told = error.problems, str(error)
    assert problems
    assert told
    for problem in problems:
        assert problem.message
        assert problem.line is None or problem.line >= 1
    return None


@given(scenes(), st.data())
@settings(max_examples=100, deadline=None)
def test_damaged_scenes(data: Data, more: st.DataObject) -> None:
    text = dump_scene(Scene.model_validate(data))
    for _ in range(more.draw(st.integers(1, 4))):
        start = more.draw(st.integers(0, len(text)))
        length = more.draw(st.sampled_from([0, 0, 1, 2, 5, 20]))
        text = text[:start] + more.draw(st.sampled_from(FRAGMENTS)) + text[start + length :]
    load(text.encode())


@given(scenes(), st.data())
@settings(max_examples=100, deadline=None)
def test_values_in_wrong_places(data: Data, more: st.DataObject) -> None:
    """Any value of the scene replaced by another of its values, or by something that never fits."""
    values: list[object] = []

    def replaced(part: object, number: list[int], chosen: int, by: object) -> object:
        number[0] += 1
        if number[0] == chosen:
            return by
        if isinstance(part, dict):
            return {key: replaced(each, number, chosen, by) for key, each in part.items()}
        if isinstance(part, list):
            return [replaced(each, number, chosen, by) for each in part]
        values.append(part)
        return part

    count = [0]
    replaced(data, count, -1, None)
    strange = [
        None,
        True,
        [],
        {},
        {"type": None},
        {"type": "drag"},
        [[]],
        "",
        "x",
        -1,
        0,
        float("nan"),
        10**40,
    ]
    chosen = more.draw(st.integers(1, count[0]))
    by = more.draw(st.sampled_from([*strange, *values]))
    load(yaml.safe_dump(replaced(data, [0], chosen, by), allow_unicode=True).encode())


@given(st.binary(max_size=60))
@settings(max_examples=100, deadline=None)
def test_any_bytes(content: bytes) -> None:
    load(content)


@given(st.text(max_size=40))
@settings(max_examples=100, deadline=None)
def test_any_override(text: str) -> None:
    content = b"duration: 1\nemitters: {e: {rate: 1, speed: {uniform: [1, 2]}}}\nforces: [{type: gravity}]\n"
    load(content, [text])


@given(
    st.lists(
        st.sampled_from(["emitters", "e", "forces", "0", "look", "speed", "uniform", "fps", "on", "-1", ""]),
        max_size=4,
    ),
    st.sampled_from(FRAGMENTS),
)
@settings(max_examples=100, deadline=None)
def test_overrides_that_nearly_fit(steps: list[str], value: str) -> None:
    content = b"duration: 1\nemitters: {e: {rate: 1, speed: {uniform: [1, 2]}}}\nforces: [{type: gravity}]\n"
    load(content, [f"{'.'.join(steps)}={value}"])

# ruff: noqa: E501 - a table of cases reads best with one line for each

from pathlib import Path

import numpy as np
import pytest

from particlecli.errors import Problem, SceneError
from particlecli.scene.load import load_scene

BASE = "duration: 1\nparticles: {p: {positions: [[0, 0, 0]]}}\n"
"""A valid scene of two lines, which others begin with."""


def problems(folder: Path, text: str, *overrides: str) -> list[Problem]:
    file = folder / "scene.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        load_scene(file, overrides)
    assert caught.value.exit_code == 2
    for problem in caught.value.problems:
        assert "pydantic" not in problem.message
        assert "Input should" not in problem.message
    return caught.value.problems


def test_a_scene(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(BASE + "fps: 1e1\nseed: 010\n")
    scene = load_scene(tmp_path / "scene.yaml")
    assert (scene.fps, scene.seed, scene.frame_count) == (10.0, 10, 11)
    assert scene.folder == tmp_path


@pytest.mark.parametrize(
    ("extra", "line", "column", "key", "message"),
    [
        ("durations: 2", 3, 1, "durations", 'unknown key; did you mean "duration"?'),
        ("zzz: 2", 3, 1, "zzz", "unknown key; known here: title, seed, duration"),
        ("fps: fast", 3, 6, "fps", 'must be a number, not "fast" (frames a second)'),
        ('fps: "30"', 3, 6, "fps", 'must be a number, not "30"'),
        ("fps: true", 3, 6, "fps", "must be a number, not true"),
        ("fps: [1]", 3, 6, "fps", "must be a number, not a list"),
        ("fps:", 3, 5, "fps", "has no value; it must be a number, or delete the key"),
        ("fps: -3", 3, 6, "fps", "must be positive, and is -3"),
        ("fps: .nan", 3, 6, "fps", "must be a finite number"),
        ("fps: .inf", 3, 6, "fps", "must be a finite number"),
        ("fps: 1e999", 3, 6, "fps", "must be a finite number"),
        (f"fps: {'9' * 400}", 3, 6, "fps", "must be a finite number"),
        ("fps: 1\nfps: 2", 4, 1, "fps", "this key stands here twice; the first is in line 3"),
        ("seed: 1.5", 3, 7, "seed", "must be a whole number, not 1.5"),
        ("seed: yes", 3, 7, "seed", 'must be a whole number, not "yes"'),
        ("seed: -1", 3, 7, "seed", "must not be negative, and is -1"),
        ("title: 5", 3, 8, "title", "must be text, not 5"),
        ("precision: duoble", 3, 12, "precision", 'unknown choice "duoble"; did you mean "double"?'),
        ("integrator: {type: rk5}", 3, 20, "integrator.type", 'unknown choice "rk5"; did you mean "rk4"? Known here: euler, midpoint'),
        ("integrator: rk4", 3, 13, "integrator", "must be a mapping of keys to values"),
        ("integrator: {dt: 0}", 3, 18, "integrator.dt", "must be positive, and is 0"),
        ("integrator:\n  dt: -0.1", 4, 7, "integrator.dt", "must be positive, and is -0.1"),
        ("forces: {type: gravity}", 3, 1, "forces", "must be a list in square brackets, not a mapping"),
        ("forces: [{type: drga}]", 3, 17, "forces[0].type", 'unknown type "drga"; did you mean "drag"?'),
        ("forces: [{type: []}]", 3, 17, "forces[0].type", "unknown type a list; known here: gravity"),
        ("forces: [{}]", 3, 10, "forces[0]", "needs a `type`: gravity, point_gravity"),
        ("forces: [5]", 3, 10, "forces[0]", "must be a mapping of keys to values, not 5"),
        ("forces:\n  - type: drag", 4, 5, "forces[0].coefficient", "is missing: k, kg/s"),
        (
            "forces:\n- {type: drag, coefficient: 1}\n- {type: orbit, strength: 1, exponnt: 2}",
            5, 30, "forces[1].exponnt", 'unknown key; did you mean "exponent"?',
        ),
        ("forces: [{type: gravity, core: 1}]", 3, 26, "forces[0].core", "this key belongs to vortex and orbit"),
        ("forces: [{type: gravity, acceleration: [0, 1]}]", 3, 40, "forces[0].acceleration", "must be 3 numbers, not 2"),
        ("forces: [{type: gravity, acceleration: [0, 1, 2, 3]}]", 3, 40, "forces[0].acceleration", "must be 3 numbers, not 4"),
        ("forces: [{type: gravity, acceleration: []}]", 3, 40, "forces[0].acceleration", "must be 3 numbers, not 0"),
        ("forces: [{type: gravity, acceleration: 9.81}]", 3, 40, "forces[0].acceleration", "must be a list in square"),
        ("forces: [{type: gravity, acceleration: [0, x, 0]}]", 3, 44, "forces[0].acceleration[1]", "must be a number"),
        ("forces: [{type: gravity, acceleration: [0, .nan, 0]}]", 3, 44, "forces[0].acceleration[1]", "must be a finite"),
        ("forces: [{type: force_field, force: [x, y]}]", 3, 37, "forces[0].force", "must be 3 expressions, not 2"),
        ("forces: [{type: force_field}]", 3, 17, "forces[0].type", "give either `force`"),
        (
            "forces: [{type: force_field, potential: x, force: [x, y, z]}]",
            3, 41, "forces[0].potential", "give either `force`",
        ),
        ('forces: [{type: force_field, potential: "x.y"}]', 3, 41, "forces[0].potential", "a dot between names"),
        ("forces: [{type: force_field, potential: u*x}]", 3, 41, "forces[0].potential", "unknown name `u`"),
        ("forces: [{type: force_field, potential: exec(x)}]", 3, 41, "forces[0].potential", "unknown function"),
        ("forces: [{type: force_field, potential: x/0}]", 3, 41, "forces[0].potential", "division by zero"),
        ("planes: [{normal: [0, 0, 0]}]", 3, 19, "planes[0].normal", "must not be the zero vector"),
        ("planes: [{friction: -1}]", 3, 21, "planes[0].friction", "must not be negative, and is -1"),
        ("planes: [{friction: {}}]", 3, 11, "planes[0].friction", "must be a number or {coulomb: μ}"),
        ("planes: [{friction: {columb: 1}}]", 3, 22, "planes[0].friction.columb", 'did you mean "coulomb"?'),
        ("planes: [{restitution: 1.5}]", 3, 24, "planes[0].restitution", "must be at most 1, not 1.5"),
        ("planes: [{on: p}]", 3, 15, "planes[0].on", "must be a list in square brackets"),
        ("planes: [{on: [5]}]", 3, 16, "planes[0].on[0]", "must be text, not 5"),
        ("planes: [{on: [a b]}]", 3, 16, "planes[0].on[0]", '"a b" is not a name'),
        ("flows: {a b: []}", 3, 9, "flows.a b", "a name is made of letters"),
        ("flows: {a: [{type: curl_noise, length: 1, speed: 1, octaves: 9}]}", 3, 62, "flows.a[0].octaves", "at most 8"),
        ("flows: {a: [{type: expression, velocity: [t, x, v]}]}", 3, 49, "flows.a[0].velocity[2]", "unknown name `v`"),
        ("emitters: {e: {}}", 3, 12, "emitters.e", "nothing is ever born"),
        ("emitters: {e: {rate: -75}}", 3, 22, "emitters.e.rate", "must not be negative"),
        ("emitters: {e: {rate: 2*x}}", 3, 22, "emitters.e.rate", "unknown name `x`; known here: t and pi"),
        ("emitters: {e: {rate: [1]}}", 3, 22, "emitters.e.rate", "must be a number or an expression in quotes"),
        ("emitters: {e: {rate: .inf}}", 3, 22, "emitters.e.rate", "must be a finite number"),
        ("emitters: {e: {rate: 1, stop: 1, start: 2}}", 3, 31, "emitters.e.stop", "must not be before start"),
        ("emitters: {e: {rate: 1, mass: 0}}", 3, 31, "emitters.e.mass", "must be positive, and is 0"),
        ("emitters: {e: {rate: 1, mass: -1}}", 3, 31, "emitters.e.mass", "must be positive, and is -1"),
        ("emitters: {e: {rate: 1, mass: heavy}}", 3, 31, "emitters.e.mass", 'must be a number, not "heavy"'),
        ("emitters: {e: {rate: 1, mass: {uniform: [0, 1]}}}", 3, 25, "emitters.e.mass", "must be positive, and can be 0"),
        ("emitters: {e: {rate: 1, mass: {log_normal: [1, 119]}}}", 3, 44, "emitters.e.mass.log_normal", "no number can hold"),
        ("emitters: {e: {rate: 1, mass: {normal: [1, 1e308]}}}", 3, 40, "emitters.e.mass.normal", "no number can hold"),
        ("emitters: {e: {rate: 1, mass: {uniform: [2, 1]}}}", 3, 41, "emitters.e.mass.uniform", "the lower end"),
        ("emitters: {e: {rate: 1, mass: {uniform: 1}}}", 3, 41, "emitters.e.mass.uniform", "must be a list"),
        ("emitters: {e: {rate: 1, mass: {uniform: [1]}}}", 3, 41, "emitters.e.mass.uniform", "must be 2 numbers, not 1"),
        ("emitters: {e: {rate: 1, mass: {unifrom: [1, 2]}}}", 3, 32, "emitters.e.mass.unifrom", 'did you mean "uniform"?'),
        ("emitters: {e: {rate: 1, speed: {normal: [1, 1]}}}", 3, 25, "emitters.e.speed", "must not be negative, and can be -5"),
        ("emitters: {e: {rate: 1, speed: {choice: []}}}", 3, 41, "emitters.e.speed.choice", "must not be empty"),
        ("emitters: {e: {bursts: [{time: 1}]}}", 3, 25, "emitters.e.bursts[0].count", "is missing: how many"),
        ("emitters: {e: {bursts: [{time: 1, count: 0}]}}", 3, 42, "emitters.e.bursts[0].count", "must be positive"),
        ("emitters: {e: {bursts: [{time: 1, count: 1e30}]}}", 3, 42, "emitters.e.bursts[0].count", "is too large"),
        ("emitters: {e: {rate: 1, shape: {type: cube}}}", 3, 39, "emitters.e.shape.type", 'unknown type "cube"'),
        ("emitters: {e: {rate: 1, cooling: {}}}", 3, 25, "emitters.e.cooling", "nothing cools here"),
        (
            "emitters: {e: {rate: 1, dies: {outside: {min: [0, 0, 0], max: [1, 0, 1]}}}}",
            3, 47, "emitters.e.dies.outside.min", "each coordinate must be below that of max",
        ),
        ("camera: {look_at: [0, 1.5, 6]}", 3, 19, "camera.look_at", "is the camera's own position"),
        ("camera: {up: [0, 0.5, 6]}", 3, 14, "camera.up", "is the direction the camera looks in"),
        ("camera: {resolution: [1280, 7]}", 3, 29, "camera.resolution[1]", "must be at least 16, not 7"),
        ("look: {background: red}", 3, 20, "look.background", 'must be a colour such as "#ff8800", not "red"'),
        ("look:\n  background: #05060a", 4, 14, "look.background", "has no value; a colour needs quotes"),
        ("look: {groups: {p: {color: red}}}", 3, 28, "look.groups.p.color", "must be #rrggbb, blackbody, group"),
        ("look: {groups: {p: {color: }}}", 3, 28, "look.groups.p.color", "has no value; a colour needs quotes"),
        ("look: {groups: {p: {color: 5}}}", 3, 28, "look.groups.p.color", "must be #rrggbb, blackbody, group"),
        ("look: {groups: {p: {color: {by: id, map: fir, range: [0, 1]}}}}", 3, 42, "look.groups.p.color.map", '"fire"'),
        ("look: {groups: {p: {color: {by: id, map: fire}}}}", 3, 33, "look.groups.p.color.by", "needs a range"),
        ("look: {groups: {p: {color: {by: id, map: fire, range: [1, 0]}}}}", 3, 55, "look.groups.p.color.range", "below"),
        ("look: {groups: {p: {radius: 1, pixels: 2}}}", 3, 40, "look.groups.p.pixels", "give radius (metres) or pixels"),
        ("look: {ground: {visible: yes}}", 3, 26, "look.ground.visible", 'must be true or false, not "yes"'),
        ("outputs: [{type: video, path: ../x.mp4}]", 3, 31, "outputs[0].path", "must not lead upwards"),
        ("outputs: [{type: video, path: a/../../x.mp4}]", 3, 31, "outputs[0].path", "must not lead upwards"),
        ("outputs: [{type: video, path: /tmp/x.mp4}]", 3, 31, "outputs[0].path", "must be a relative path"),
        ("outputs: [{type: video, path: 'C:x.mp4'}]", 3, 31, "outputs[0].path", "must be a relative path"),
        ("outputs: [{type: video, path: '..\\x.mp4'}]", 3, 31, "outputs[0].path", "must be a plain path"),
        ("outputs: [{type: video, path: x.avi}]", 3, 31, "outputs[0].path", "must end in .mp4 or .webm or .gif"),
        ("outputs: [{type: trajectory, path: x.txt}]", 3, 36, "outputs[0].path", "must end in .npz or .csv"),
        ("outputs: [{type: frames, path: ''}]", 3, 32, "outputs[0].path", "must not be empty"),
        ("a: &a [*a]", 3, 8, "a[0]", "*a stands within &a itself, so it would never end"),
        ("a: [1, 2", 3, 4, "", "this list is not closed"),
    ],
)  # fmt: skip
def test_bad_input(tmp_path: Path, extra: str, line: int, column: int, key: str, message: str) -> None:
    found = problems(tmp_path, BASE + extra)[0]
    assert (found.line, found.column, found.key) == (line, column, key)
    assert message in found.message


@pytest.mark.parametrize(
    ("group", "column", "key", "message"),
    [
        ("{}", 13, "", "where are the particles?"),
        ("{positions: []}", 28, ".positions", "must not be empty"),
        ("{positions: [[0, 0]]}", 29, ".positions[0]", "must be 3 numbers, not 2"),
        ("{positions: [[0, 0, x]]}", 36, ".positions[0][2]", "must be a number"),
        ("{positions: [[0, 0, 0]], file: p.csv}", 47, ".file", "give `positions` or `file`, not both"),
        ("{positions: [[0, 0, 0]], masses: [1, 2]}", 49, ".masses", "must be as many as positions: 1, not 2"),
        ("{positions: [[0, 0, 0]], masses: [1], mass: 2}", 60, ".mass", "give `masses` or `mass`, not both"),
        ("{layout: {type: ball, radius: 1, count: 1}, masses: [1]}", 68, ".masses", "goes with `positions`"),
        ("{layout: {type: ball, radius: 1}}", 17, ".layout.count", "is missing: how many"),
        ("{layout: {type: grid, counts: [1, 1, 1], spacing: 0}}", 66, ".layout.spacing", "must be positive"),
        ("{file: p.txt}", 23, ".file", "must end in .csv or .npz"),
        ("{file: ../p.csv}", 23, ".file", "must not lead upwards"),
        ("{file: /p.csv}", 23, ".file", "must be a relative path"),
        ("{file: p.csv}", 23, ".file", 'there is no file "p.csv"'),
        ("", 16, "", "has no value"),
    ],
)  # fmt: skip
def test_bad_particles(tmp_path: Path, group: str, column: int, key: str, message: str) -> None:
    found = problems(tmp_path, f"duration: 1\nparticles: {{p: {group}}}")[0]
    assert (found.line, found.column, found.key) == (2, column, f"particles.p{key}")
    assert message in found.message


def test_all_problems_in_the_order_of_the_file(tmp_path: Path) -> None:
    text = """\
fps: 0
duration: -1
emitters:
  sparks:
    rat: 3
    rate: x
  sparks:
    rate: 1
forces:
  - {type: gravty}
  - {type: drag, coefficient: -1, flow: 5}
title: [1]
"""
    found = problems(tmp_path, text)
    assert [(each.line, each.key) for each in found] == [
        (1, "fps"),
        (2, "duration"),
        (5, "emitters.sparks.rat"),
        (6, "emitters.sparks.rate"),
        (7, "emitters.sparks"),
        (10, "forces[0].type"),
        (11, "forces[1].coefficient"),
        (11, "forces[1].flow"),
        (12, "title"),
    ]


def test_message_names_file_line_column_and_key(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(BASE + "planes:\n  - {restitutin: 1}\n")
    with pytest.raises(SceneError) as caught:
        load_scene(file)
    expected = f'{file}:4:6  planes[0].restitutin  unknown key; did you mean "restitution"?'
    assert str(caught.value) == expected


def test_missing_duration(tmp_path: Path) -> None:
    (found,) = problems(tmp_path, "particles: {p: {positions: [[0, 0, 0]]}}")
    assert (found.key, found.message, found.line) == ("duration", "is missing: how long it lasts, s", 1)


@pytest.mark.parametrize(
    ("content", "message", "line"),
    [
        (b"", "is empty", None),
        (b"# nothing here\n", "is empty", None),
        (b"null\n", "is empty", None),
        (b"- a\n", "must be a mapping of keys such as duration:, not a list", 1),
        (b"hello\n", 'must be a mapping of keys such as duration:, not "hello"', 1),
        (b"\x89PNG\r\n\x1a\n\x00\x00", "is not a text file", None),
        (b"a: \x00", "this is not a text file", 1),
        ("duration: 1".encode("utf-16"), "is not a text file", None),
        (b"duration: 1\n---\nduration: 2\n", "a second document begins here", 2),
        (b"a" * 8_000_001, "longer than", None),
    ],
)
def test_files_that_are_no_scenes(tmp_path: Path, content: bytes, message: str, line: int | None) -> None:
    file = tmp_path / "scene.yaml"
    file.write_bytes(content)
    with pytest.raises(SceneError) as caught:
        load_scene(file)
    (problem,) = caught.value.problems
    assert message in problem.message
    assert problem.line == line
    assert str(caught.value).startswith(str(file))


def test_no_such_file(tmp_path: Path) -> None:
    (tmp_path / "campfire.yaml").write_text(BASE)
    with pytest.raises(SceneError, match=r'no such file; did you mean ".*/campfire\.yaml"\?'):
        load_scene(tmp_path / "campfre.yaml")
    with pytest.raises(SceneError, match="no such file"):
        load_scene(tmp_path / "nowhere" / "scene.yaml")
    with pytest.raises(SceneError, match="is a folder"):
        load_scene(tmp_path)
    with pytest.raises(SceneError, match="cannot be read"):
        load_scene("a\0b")


def test_byte_order_mark_and_windows_lines(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_bytes(b"\xef\xbb\xbf" + BASE.replace("\n", "\r\n").encode())
    assert load_scene(file).duration == 1
    (found,) = problems(tmp_path, "\ufeff" + BASE + "zzz: 1")
    assert (found.line, found.column) == (3, 1)


def test_many_problems_are_counted(tmp_path: Path) -> None:
    found = problems(tmp_path, BASE + "planes: [" + "5, " * 500 + "5]")
    assert len(found) == 101
    assert found[-1].message == "and 401 more problems"


def test_problems_of_later_phases_find_their_place(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(BASE)
    scene = load_scene(file, ["fps=10"])
    late = SceneError([Problem("particles.p.positions[0]", "too far"), Problem("fps", "too low"), Problem("", "?")])
    first, second, third = scene.located(late).problems
    assert (first.line, first.column) == (2, 29)
    assert second.option == "--set fps"
    assert (third.line, third.column) == (1, 1)
    assert scene.located(late).source == str(file)


def test_a_long_scene_loads(tmp_path: Path) -> None:
    rows = np.arange(30_000).reshape(-1, 3).tolist()
    (tmp_path / "scene.yaml").write_text(f"duration: 1\nparticles: {{p: {{positions: {rows}}}}}\n")
    assert len(load_scene(tmp_path / "scene.yaml").particles["p"].positions or ()) == 10_000

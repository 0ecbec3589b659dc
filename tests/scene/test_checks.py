# ruff: noqa: E501 - a table of cases reads best with one line for each

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from particlecli.errors import SceneError
from particlecli.scene.checks import check_scene, problems
from particlecli.scene.load import load_scene
from particlecli.scene.model import Scene
from particlecli.scene.reader import parse

TEXT = """\
duration: 2
flows:
  wind: [{type: uniform, velocity: [1, 0, 0]}]
particles:
  balls: {positions: [[0, 0, 0], [1, 1, 1]]}
emitters:
  sparks: {rate: 10, lifetime: 2, temperature: 1500}
  smoke: {rate: 10, motion: first_order, flow: wind}
forces:
  - {type: gravity}
"""

CASES = [
    # what is changed, the key, and what is said
    ("forces.0.on=[spark]", "forces[0].on[0]", 'there is no group "spark"; did you mean "sparks"?'),
    ("forces.0.on=[balls, wind]", "forces[0].on[1]", 'there is no group "wind"; known here: balls, sparks, smoke'),
    ("forces.0.on=[balls, balls]", "forces[0].on[1]", '"balls" is named twice'),
    ("forces.0.on=[smoke]", "forces[0].on[0]", 'forces do not move "smoke", a first_order group'),
    ("forces.0={type: drag, coefficient: 1, flow: wnd}", "forces[0].flow", 'there is no flow "wnd"; did you mean "wind"?'),
    ("forces.0={type: quadratic_drag, coefficient: 1, flow: sparks}", "forces[0].flow", 'there is no flow "sparks"'),
    ("planes=[{on: [sparks]}, {on: [bals]}]", "planes[1].on[0]", 'there is no group "bals"; did you mean "balls"?'),
    ("emitters.balls={rate: 1}", "emitters.balls", "`particles` have a group of this name too"),
    ("emitters.smoke.flow=", "emitters.smoke.motion", "a first_order group needs a `flow`"),
    ("emitters.smoke.flow=win", "emitters.smoke.flow", 'there is no flow "win"; did you mean "wind"?'),
    ("emitters.smoke.speed=1", "emitters.smoke.speed", "has no meaning for a first_order group"),
    ("emitters.smoke.mass={uniform: [1, 2]}", "emitters.smoke.mass", "has no meaning for a first_order group"),
    ("emitters.smoke.direction={spread: 5}", "emitters.smoke.direction", "has no meaning for a first_order group"),
    ("particles.balls={motion: first_order, flow: wind, positions: [[0, 0, 0]], velocity: [1, 0, 0]}", "particles.balls.velocity", "has no meaning"),
    ("particles.balls={motion: first_order, flow: wind, positions: [[0, 0, 0]], velocities: [[1, 0, 0]]}", "particles.balls.velocities", "has no meaning"),
    ("particles.balls={motion: first_order, flow: wind, positions: [[0, 0, 0]], masses: [1]}", "particles.balls.masses", "has no meaning"),
    ("emitters.sparks.flow=wind", "emitters.sparks.flow", "only carries groups with `motion: first_order`"),
    ("particles.balls.cooling={rate: 1}", "particles.balls.cooling", "the group has no temperature that could fall"),
    ("particles.balls.dies={colder_than: 5}", "particles.balls.dies.colder_than", "the group has no temperature"),
    ("emitters.sparks.rate=log(t)", "emitters.sparks.rate", "is -inf at t = 0 s; it must be finite all the time"),
    ("emitters.sparks.rate=1/(t - 1)", "emitters.sparks.rate", "is inf at t = 1 s"),
    ("emitters.sparks.rate=-t", "emitters.sparks.rate", "is never positive while the emitter is on"),
    ("particles.balls.dies={outside: {min: [-1, -1, -1], max: [1, 1, 0.9]}}", "particles.balls.positions[1]", "lies outside the box"),
    ("particles.balls={layout: {type: ball, radius: 2, count: 5}, dies: {outside: {min: [-2, -2, -2], max: [2, 1, 2]}}}", "particles.balls.layout", "lies outside the box"),
    ("particles.balls={layout: {type: grid, counts: [1, 9, 1], spacing: 1}, dies: {outside: {min: [-1, -3, -1], max: [1, 9, 1]}}}", "particles.balls.layout", "lies outside"),
    ("particles.balls={layout: {type: line, start: [5, 0, 0], end: [-5, 0, 0], count: 5}, dies: {outside: {min: [-4, -1, -1], max: [9, 1, 1]}}}", "particles.balls.layout", "lies outside"),
    ("emitters.sparks.dies={outside: {min: [1, -1, -1], max: [2, 1, 1]}}", "emitters.sparks.shape", "lies outside the box"),
    ("integrator.type=velocity_verlet", "integrator.type", 'and "smoke", a first_order group, has no velocity; use euler, midpoint, rk3 or rk4'),
    ("integrator.type=symplectic_euler", "integrator.type", 'symplectic_euler advances positions and velocities in turn'),
    ("integrator.type=composition8", "integrator.type", 'composition8 advances positions and velocities in turn'),
    ("reference=[{at: 1, group: bals, energy: 1, tolerance: 1}]", "reference[0].group", 'there is no group "bals"; did you mean "balls"?'),
    ("reference=[{at: 2.5, group: balls, energy: 1, tolerance: 1}]", "reference[0].at", "is after the end of the scene, which lasts 2 s"),
    ("reference=[{at: 1, group: balls, particles: [0, 2], energy: 1, tolerance: 1}]", "reference[0].particles[1]", "there are 2 particles, numbered from 0 to 1"),
    ("reference=[{at: 1, group: balls, particles: [1, 1], energy: 1, tolerance: 1}]", "reference[0].particles[1]", "1 is named twice"),
    ("reference=[{at: 1, group: balls, positions: [[0, 0, 0]], tolerance: 1}]", "reference[0].positions", "must be as many as the particles they are about: 2, not 1"),
    ("reference=[{at: 1, group: sparks, particles: [5, 7], velocities: [[0, 0, 0]], tolerance: 1}]", "reference[0].velocities", "must be as many as the particles they are about: 2, not 1"),
    ("reference=[{at: 1, group: smoke, energy: 5, tolerance: 1}]", "reference[0].energy", "a first_order group has no velocity"),
    ("reference=[{at: 1, group: smoke, quantity: 2*speed, value: 5, tolerance: 1}]", "reference[0].quantity", "a first_order group has no velocity"),
    ("look.groups.spark={}", "look.groups.spark", 'there is no group "spark"; did you mean "sparks"?'),
    ("look.groups.smoke.as=streaks", "look.groups.smoke.as", "no velocity to draw streaks along"),
    ("look.groups.smoke.color={by: speed, map: ice, range: [0, 1]}", "look.groups.smoke.color.by", "a first_order group has no velocity"),
    ("look.groups.smoke.color=blackbody", "look.groups.smoke.color", "a blackbody has a temperature"),
    ("look.groups.balls.color={by: temperature, map: ice, range: [0, 1]}", "look.groups.balls.color.by", "the group has no temperature"),
    ("look.groups.smoke.color={by: age, map: ice}", "look.groups.smoke.color.by", "so ages need a range"),
    ("look.groups.smoke.fade_in=0.1", "look.groups.smoke.fade_in", "give it a `lifetime`"),
    ("look.groups.balls.fade_out=0.1", "look.groups.balls.fade_out", "give it a `lifetime`"),
    ("outputs=[{type: frames}, {type: frames, path: ./Frames/}]", "outputs[1].path", "outputs[0] goes there"),
    ("outputs=[{type: video, path: a.mp4}, {type: frames, path: a.mp4/b}]", "outputs[1].path", "lies in outputs[0], which is a file"),
]  # fmt: skip


def plain(text: str) -> Any:
    root, _ = parse(text)
    assert root is not None
    return root.plain()


def scene(*changes: str, text: str = TEXT) -> Scene:
    data = plain(text)
    for change in changes:
        key, _, value = change.partition("=")
        *steps, last = key.split(".")
        part = data
        for step in steps:
            part = part[int(step)] if isinstance(part, list) else part.setdefault(step, {})
        part[int(last) if isinstance(part, list) else last] = plain(value) if value else None
    return Scene.model_validate(data)


@pytest.mark.parametrize(("change", "key", "message"), CASES)
def test_what_does_not_fit(change: str, key: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError) as caught:
        check_scene(scene(change))
    assert [problem.key for problem in caught.value.problems] == [key]
    assert message in caught.value.problems[0].message
    file = tmp_path / "scene.yaml"
    file.write_text(TEXT)
    with pytest.raises(SceneError) as located:
        load_scene(file, [change])
    assert message in str(located.value)


@pytest.mark.parametrize(
    "change",
    [
        "forces.0.on=[]",
        "forces.0={type: drag, coefficient: 1, flow: wind}",
        "look.groups.sparks={color: blackbody, fade_in: 0.1, as: streaks}",
        "look.groups.sparks.color={by: age, map: ice}",
        "look.groups.smoke.color={by: age, map: ice, range: [0, 2]}",
        "emitters.sparks.rate=sin(t)",
        "emitters.sparks.rate=0",
        "emitters.sparks.start=5",
        "emitters.sparks.dies={outside: {min: [0, 0, 0], max: [2, 1, 1]}, colder_than: 5}",
        "emitters.sparks.cooling={rate: 1}",
        "particles.balls.dies={outside: {min: [0, 0, 0], max: [1, 1, 1]}}",
        "particles.balls={positions: [[0, 0, 0]], temperatures: [5], cooling: {rate: 1}}",
        "outputs=[{type: frames}, {type: video, path: frames/a.mp4}, {type: trajectory, path: frames/a.npz}]",
    ],
)
def test_what_fits(change: str) -> None:
    assert not problems(scene(change))


def test_nothing_to_simulate() -> None:
    assert problems(Scene(duration=1)) == [((), "there is nothing to simulate: give `particles` or `emitters`")]


NEWTONIAN = TEXT.replace("  smoke: {rate: 10, motion: first_order, flow: wind}\n", "")


@pytest.mark.parametrize(
    "force",
    [
        "{type: drag, coefficient: 1}",
        "{type: quadratic_drag, coefficient: 1}",
        "{type: force_field, force: [v, 0, 0]}",
        "{type: drag, coefficient: 1, on: [balls]}",
    ],
)
@pytest.mark.parametrize("scheme", ["velocity_verlet", "yoshida4", "composition8"])
def test_splittings_need_forces_of_position(scheme: str, force: str) -> None:
    ((path, message),) = problems(scene(f"integrator.type={scheme}", f"forces.0={force}", text=NEWTONIAN))
    assert path == ("integrator", "type")
    assert "forces[0]" in message
    assert "would fall to first order unnoticed; use midpoint, rk3 or rk4" in message


@pytest.mark.parametrize(
    "force",
    [
        "{type: gravity}",
        "{type: force_field, force: [x, t, 0]}",
        "{type: force_field, potential: x*y}",
        "{type: drag, coefficient: 1, on: []}",
    ],
)
def test_velocity_verlet_serves_forces_of_position(force: str) -> None:
    assert not problems(scene("integrator.type=velocity_verlet", f"forces.0={force}", text=NEWTONIAN))
    assert not problems(
        scene("integrator.type=symplectic_euler", "forces.0={type: drag, coefficient: 1}", text=NEWTONIAN)
    )


def from_file(folder: Path, name: str, extra: str = "") -> Scene:
    file = folder / "scene.yaml"
    file.write_text(f"duration: 1\nparticles:\n  dust: {{file: {name}{extra}}}\n")
    return load_scene(file)


def test_file_with_temperatures(tmp_path: Path) -> None:
    (tmp_path / "hot.csv").write_text("x,y,z, temperature\n0,0,0,500\n")
    np.savez(tmp_path / "hot.npz", positions=np.zeros((1, 3)), temperatures=np.ones(1))
    (tmp_path / "cold.csv").write_text("x,y,z\n0,0,0\n")
    (tmp_path / "broken.npz").write_bytes(b"nothing")
    for name in ("hot.csv", "hot.npz"):
        assert from_file(tmp_path, name, ", cooling: {rate: 1}").particles["dust"].file == name
    for name in ("cold.csv", "broken.npz"):
        with pytest.raises(SceneError, match=r":3:\d+  particles\.dust\.cooling  the group has no temperature"):
            from_file(tmp_path, name, ", cooling: {rate: 1}")


def test_file_must_be_there_and_inside(tmp_path: Path) -> None:
    folder = tmp_path / "scenes"
    (folder / "sub").mkdir(parents=True)
    (tmp_path / "secret.csv").write_text("x,y,z\n0,0,0\n")
    (folder / "link.csv").symlink_to(tmp_path / "secret.csv")
    (folder / "sub" / "dust.csv").write_text("x,y,z\n0,0,0\n")
    (folder / "folder.csv").mkdir()
    assert from_file(folder, "sub/dust.csv").folder == folder
    with pytest.raises(SceneError, match=r":3:16  particles\.dust\.file  leads out of the scene's folder"):
        from_file(folder, "link.csv")
    with pytest.raises(SceneError, match=r":3:16  particles\.dust\.file  there is no file"):
        from_file(folder, "nowhere.csv")
    with pytest.raises(SceneError, match=r":3:16  particles\.dust\.file  there is no file"):
        from_file(folder, "folder.csv")


def test_problems_of_a_scene_made_in_python_have_no_place() -> None:
    with pytest.raises(SceneError) as caught:
        check_scene(scene("forces.0.on=[spark]"))
    assert str(caught.value) == 'scene  forces[0].on[0]  there is no group "spark"; did you mean "sparks"?'


def test_places_in_the_file(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(
        TEXT + "look:\n  groups:\n    spark:\n      as: dots\n    smoke: {as: streaks}\nplanes: [{on: [bals]}]\n"
    )
    with pytest.raises(SceneError) as caught:
        load_scene(file)
    assert [(each.line, each.column, each.key) for each in caught.value.problems] == [
        (13, 5, "look.groups.spark"),
        (15, 17, "look.groups.smoke.as"),
        (16, 16, "planes[0].on[0]"),
    ]

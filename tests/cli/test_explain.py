from __future__ import annotations

import json
from pathlib import Path

from tests.cli.conftest import Cli, imported_by


def test_state_is_told_with_its_bytes(cli: Cli, scene: Path) -> None:
    result = cli("explain", "balls.yaml")
    assert result.returncode == 0
    assert "Three balls" in result.stdout
    assert "symplectic_euler, single precision: 2 steps of 0.05 s a frame, 3 frames" in result.stdout
    assert "state x 4, y 4, z 4, u 4, v 4, w 4" in result.stdout


def test_json_is_one_object(cli: Cli, scene: Path) -> None:
    facts = json.loads(cli("explain", "balls.yaml", "--json", "--set", "precision=double").stdout)
    (group,) = facts["groups"]
    assert group["name"] == "balls"
    assert group["capacity"] >= 3
    assert group["bytes_per_particle"] == sum(group["state"].values()) == 48
    assert group["forces"] == [{"type": "gravity", "flow": None}]
    assert facts["kernels"] == 1


def test_children_couplings_and_fixed_groups_are_told(cli: Cli, tmp_path: Path) -> None:
    (tmp_path / "kin.yaml").write_text(
        "duration: 1\n"
        "frames: {tip: {translate: [0, t, 0]}}\n"
        "particles:\n"
        "  arm: {positions: [[0, 0, 0]], motion: fixed, frame: tip}\n"
        "  stars: {positions: [[1, 0, 0], [2, 0, 0]]}\n"
        "emitters:\n"
        "  shells: {rate: 1, lifetime: 0.5, children: {on: death, emitter: sparks, count: 7}}\n"
        "  sparks: {lifetime: 1}\n"
        "forces: [{type: attraction, strength: 1, on: [stars]}]\n"
        "planes: [{on: [stars]}]\n"
    )
    text = cli("explain", "kin.yaml").stdout
    assert "planes bounce; impacts at their instants" in text
    assert "bears sparks, 7 at each death" in text
    facts = json.loads(cli("explain", "kin.yaml", "--json").stdout)
    assert facts["coupled_by"] == [{"type": "attraction", "groups": ["stars"]}]
    assert facts["fixed"] == {"arm": "tip"}
    assert [group["name"] for group in facts["groups"]] == ["stars", "shells", "sparks"]


def test_pins_are_told(cli: Cli, tmp_path: Path) -> None:
    (tmp_path / "rope.yaml").write_text(
        "duration: 1\n"
        "frames: {hand: {translate: [0, t, 0]}}\n"
        "particles:\n"
        "  rope:\n"
        "    layout: {type: line, start: [0, 0, 0], end: [1, 0, 0], count: 9}\n"
        "    pins: [{where: s == 0, frame: hand}, {where: s == 1, path: [1 + t, '0', '0']}]\n"
        "forces: [{type: springs, stiffness: 9}]\n"
    )
    text = cli("explain", "rope.yaml").stdout
    assert "pinned where s == 0, stays in hand" in text
    assert "pinned where s == 1, goes along 1 + t, 0, 0 in the world" in text
    (rope,) = json.loads(cli("explain", "rope.yaml", "--json").stdout)["groups"]
    assert rope["pins"][0] == {"where": "s == 0", "frame": "hand", "path": None}


def test_what_nothing_uses_is_not_built(cli: Cli, scene: Path) -> None:
    before = json.loads(cli("explain", "balls.yaml", "--json").stdout)
    scene.write_text(scene.read_text() + "flows: {wind: [{type: uniform, velocity: [1, 0, 0]}]}\n")
    after = json.loads(cli("explain", "balls.yaml", "--json").stdout)
    assert after.pop("not_built") == {"flows": ["wind"], "groups": []}
    assert before.pop("not_built") == {"flows": [], "groups": []}
    assert after == before
    assert "not built: flow wind" in cli("explain", "balls.yaml").stdout


def test_taichi_stays_unloaded(scene: Path) -> None:
    modules = imported_by(f"from particlecli.cli import explain\nexplain.command(Path({str(scene)!r}))")
    assert "particlecli.dynamics.plan" in modules
    assert "taichi" not in modules

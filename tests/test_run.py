from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image as Pillow

from particlecli.errors import OutputError, UsageError
from particlecli.run import Progress, RunOptions, run
from particlecli.scene.load import load_scene
from particlecli.scene.look import GroupLook
from particlecli.scene.model import Scene
from particlecli.scene.outputs import FramesOutput, TrajectoryOutput
from particlecli.simulate import Simulation

SCENE = """\
title: Drops
seed: 3
duration: 0.5
fps: 10
emitters:
  drops:
    rate: 60
    speed: {uniform: [1, 2]}
    lifetime: 0.3
particles:
  balls: {positions: [[0, 1, 0], [0, 2, 0]]}
forces: [{type: gravity}]
integrator: {type: symplectic_euler, dt: 0.02}
camera: {resolution: [64, 50]}
"""

TABLE = TrajectoryOutput(type="trajectory", path="table.npz")
FRAMES = FramesOutput(type="frames", path="frames")


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    path = tmp_path / "drops.yaml"
    path.write_text(SCENE)
    return load_scene(path)


@pytest.fixture
def options(tmp_path: Path) -> RunOptions:
    return RunOptions(name="drops", folder=tmp_path / "out", outputs=(TABLE,))


def stop_at(frame: int, error: BaseException) -> Callable[[Progress], None]:
    def show(progress: Progress) -> None:
        if progress.frames == frame:
            raise error

    return show


def test_report_tells_what_happened(scene: Scene, options: RunOptions, tmp_path: Path) -> None:
    report = run(scene, options)
    assert (report.title, report.seed, report.frames) == ("Drops", 3, 6)
    assert report.births == {"balls": 2, "drops": 30}
    assert report.alive == 32 - report.deaths["drops"]["expired"]
    assert report.particle_steps > 0
    assert report.resolution is None
    phases = report.phases
    parts = (phases.choose_s, phases.compile_s, phases.simulate_s, phases.estimate_s, phases.render_s, phases.encode_s)
    spent = sum(parts)
    assert 0 < spent <= phases.wall_s
    assert [Path(file) for file in report.files] == [
        tmp_path / "out" / name for name in ("table.npz", "drops.scene.yaml", "drops.report.json")
    ]
    assert json.loads((tmp_path / "out" / "drops.report.json").read_text()) == json.loads(report.to_json())


def test_resolved_scene_makes_the_same_outputs_again(scene: Scene, options: RunOptions, tmp_path: Path) -> None:
    run(scene, options)
    again = load_scene(tmp_path / "out" / "drops.scene.yaml")
    run(again, RunOptions(name="again", folder=tmp_path / "again"))
    first, second = (tmp_path / folder / "table.npz" for folder in ("out", "again"))
    assert first.read_bytes() == second.read_bytes()


def test_data_files_go_with_the_resolved_scene(options: RunOptions, tmp_path: Path) -> None:
    np.savez(tmp_path / "stars.npz", positions=np.eye(3))
    (tmp_path / "stars.yaml").write_text("duration: 0.1\nfps: 10\nparticles: {stars: {file: stars.npz}}\n")
    run(load_scene(tmp_path / "stars.yaml"), options)
    (tmp_path / "stars.npz").unlink()
    again = load_scene(tmp_path / "out" / "drops.scene.yaml")
    run(again, RunOptions(name="again", folder=tmp_path / "again"))
    first, second = (tmp_path / folder / "table.npz" for folder in ("out", "again"))
    assert first.read_bytes() == second.read_bytes()


def test_progress_counts_frames_and_particles(scene: Scene, options: RunOptions) -> None:
    seen: list[Progress] = []
    report = run(scene, options, seen.append)
    assert [(each.frames, each.frame_count) for each in seen] == [(number, 6) for number in range(1, 7)]
    assert seen[0].alive >= 2
    assert seen[-1].alive == report.alive


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_stopped_run_leaves_nothing(
    scene: Scene, options: RunOptions, tmp_path: Path, error: type[BaseException]
) -> None:
    with pytest.raises(error):
        run(scene, options, stop_at(3, error()))
    assert [path.name for path in tmp_path.iterdir()] == ["drops.yaml"]


def test_stopped_run_keeps_older_outputs(scene: Scene, options: RunOptions, tmp_path: Path) -> None:
    run(scene, options)
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    with pytest.raises(KeyboardInterrupt):
        run(scene.model_copy(update={"seed": 4}), options, stop_at(3, KeyboardInterrupt()))
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before


def test_no_outputs_write_nothing(scene: Scene, options: RunOptions, tmp_path: Path) -> None:
    report = run(scene, replace(options, outputs=()))
    assert report.files == ()
    assert [path.name for path in tmp_path.iterdir()] == ["drops.yaml"]


def test_nothing_is_simulated_when_nothing_can_be_written(
    scene: Scene, options: RunOptions, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "out").touch()
    monkeypatch.setattr(Simulation, "__init__", lambda *_, **__: pytest.fail("simulated"))
    with pytest.raises(OutputError, match="cannot write"):
        run(scene, options)


@pytest.mark.parametrize("second", ["table.npz", "./table.npz", "drops.scene.yaml", "table.npz/frames"])
def test_two_outputs_of_one_name_are_refused(scene: Scene, options: RunOptions, second: str) -> None:
    other = FramesOutput.model_construct(type="frames", path=second)
    with pytest.raises(UsageError, match="two outputs"):
        run(scene, replace(options, outputs=(TABLE, other)))


def fields_asked_for(monkeypatch: pytest.MonkeyPatch) -> dict[str, frozenset[str]]:
    """What runs ask frames to carry, filled in when they do."""
    asked: dict[str, frozenset[str]] = {}
    begin = Simulation.__init__

    def record(self: Simulation, scene: Scene, *, fields: dict[str, frozenset[str]], **rest: object) -> None:
        asked.update(fields)
        begin(self, scene, fields=fields, **rest)  # type: ignore[arg-type]

    monkeypatch.setattr(Simulation, "__init__", record)
    return asked


def test_frames_carry_only_what_somebody_reads(
    scene: Scene, options: RunOptions, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = fields_asked_for(monkeypatch)
    run(scene, options)
    assert asked == dict.fromkeys(("balls", "drops"), frozenset({"velocities", "temperatures"}))
    run(scene, replace(options, outputs=()))
    assert asked == dict.fromkeys(("balls", "drops"), frozenset())


def test_nothing_is_rendered_when_nobody_looks(
    scene: Scene, options: RunOptions, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "particlecli.render.renderer", None)  # importing it fails
    assert run(scene, options).resolution is None


def pixels(folder: Path) -> list[np.ndarray]:
    return [np.asarray(Pillow.open(path)) for path in sorted(folder.iterdir())]


def test_scene_without_outputs_makes_a_video_named_like_its_file(
    scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    report = run(scene)
    assert report.resolution == (64, 50)
    assert report.files[0] == str(Path("outputs/drops/drops.mp4"))
    count, seconds = imageio_ffmpeg.count_frames_and_secs(report.files[0])
    assert (count, seconds) == (6, pytest.approx(0.6, abs=0.01))


def test_all_outputs_come_from_one_run(scene: Scene, options: RunOptions, tmp_path: Path) -> None:
    report = run(scene, replace(options, outputs=(TABLE, FRAMES)))
    pictures = pixels(tmp_path / "out" / "frames")
    assert {picture.shape for picture in pictures} == {(50, 64, 3)}
    assert len(pictures) == report.frames == 6
    assert pictures[0].max() > pictures[0].min()
    assert report.phases.render_s > 0


def test_draft_halves_the_resolution_and_nothing_else(scene: Scene, options: RunOptions, tmp_path: Path) -> None:
    run(scene, options)
    final = (tmp_path / "out" / "table.npz").read_bytes()
    report = run(scene, replace(options, outputs=(TABLE, FRAMES), quality="draft"))
    assert report.resolution == (32, 25)
    assert pixels(tmp_path / "out" / "frames")[0].shape == (25, 32, 3)
    assert (tmp_path / "out" / "table.npz").read_bytes() == final


def test_outputs_do_not_depend_on_the_number_of_threads(scene: Scene, options: RunOptions, tmp_path: Path) -> None:
    made = []
    for threads in (1, 2):
        run(scene, replace(options, outputs=(TABLE, FRAMES), threads=threads))
        files = [tmp_path / "out" / "table.npz", *sorted((tmp_path / "out" / "frames").iterdir())]
        made.append([file.read_bytes() for file in files])
    assert made[0] == made[1]


def test_frames_carry_what_the_look_reads(scene: Scene, options: RunOptions, monkeypatch: pytest.MonkeyPatch) -> None:
    speed = GroupLook.model_validate({"color": {"by": "speed", "map": "fire", "range": [0, 2]}})
    look = scene.look.model_copy(update={"groups": {"drops": speed}})
    asked = fields_asked_for(monkeypatch)
    run(scene.model_copy(update={"look": look}), replace(options, outputs=(FRAMES,)))
    assert asked == {"balls": frozenset(), "drops": frozenset({"velocities"})}

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

SCENE = """
duration: 0.1
particles:
  dust: {layout: {type: box, center: [0, 1, 0], size: [1, 1, 1], count: 10}}
integrator: {type: rk4, dt: 0.02}
outputs: [{type: trajectory, path: dust.npz}]
"""


SPARKS = """
duration: 0.3
fps: 10
flows: {air: [{type: curl_noise, length: 0.4, speed: 1, octaves: 2, lifetime: 1}]}
emitters:
  sparks:
    rate: 300
    speed: {uniform: [1, 4]}
    direction: {axis: [0, -1, 0], spread: 60}
    shape: {type: ball, radius: 0.1, center: [0, 0.4, 0]}
    mass: 1.0e-6
    temperature: 1500
    cooling: {rate: 2}
    dies: {colder_than: 1000}
forces: [{type: gravity}, {type: drag, coefficient: 2.0e-6, flow: air}]
planes: [{normal: [0, 1, 0], restitution: 0.5, friction: 0.3}]
integrator: {type: rk4, dt: 0.05}
outputs: [{type: trajectory, path: sparks.npz}]
"""


def run(scene: Path, output: str, *options: str, **settings: str) -> None:
    command = [sys.executable, "-m", "particlecli", "run", str(scene), "-o", output, "--quiet", *options]
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])} | settings
    subprocess.run(command, cwd=scene.parent, env=environment, check=True, capture_output=True)


def test_a_run_leaves_its_kernels_to_the_next(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(SCENE)
    cache = tmp_path / "cache"
    run(tmp_path / "scene.yaml", "out", TI_OFFLINE_CACHE_FILE_PATH=str(cache))
    assert list(cache.glob("*.tic"))


def test_runs_on_other_numbers_of_threads_find_the_same_kernels(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(SCENE)
    cache = tmp_path / "cache"
    kept = []
    for threads in ("1", "3"):
        run(tmp_path / "scene.yaml", "out", "--threads", threads, TI_OFFLINE_CACHE_FILE_PATH=str(cache))
        kept.append({path.name for path in cache.glob("*.tic")})
    assert kept[0]
    assert kept[0] == kept[1]


AGAIN_AND_AGAIN = """
import sys
from pathlib import Path
from particlecli.scene.load import load_scene
from particlecli.simulate import Simulation

kept = []
for _ in range(int(sys.argv[1])):
    simulation = Simulation(load_scene(Path("scene.yaml")))
    list(simulation)
    kept.append(simulation if "keep" in sys.argv else None)
    del simulation
"""


def test_a_scene_simulated_again_finds_its_kernels_unless_the_first_is_still_in_use(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(SCENE)
    counts = []
    for arguments in (["1", "drop"], ["3", "drop"], ["2", "keep"]):
        cache = tmp_path / "".join(arguments)
        settings = {"PYTHONPATH": str(Path(__file__).parents[1]), "TI_OFFLINE_CACHE_FILE_PATH": str(cache)}
        command = [sys.executable, "-c", AGAIN_AND_AGAIN, *arguments]
        subprocess.run(command, cwd=tmp_path, env=os.environ | settings, check=True, capture_output=True)
        counts.append(len(list(cache.glob("*.tic"))))
    assert 0 < counts[0] == counts[1] < counts[2]


@pytest.mark.slow
def test_kernels_compiled_with_all_passes_compute_the_same_bits(tmp_path: Path) -> None:
    (tmp_path / "sparks.yaml").write_text(SPARKS)
    run(tmp_path / "sparks.yaml", "fast")
    run(tmp_path / "sparks.yaml", "all", TI_CFG_OPTIMIZATION="1")
    fast, optimized = (np.load(tmp_path / name / "sparks.npz") for name in ("fast", "all"))
    assert fast["position"].size > 100
    assert {name: fast[name].tobytes() for name in fast} == {name: optimized[name].tobytes() for name in optimized}

"""A million glow dots at 1280×720, from the state of the simulation to an 8-bit picture."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import Frame
from particlecli.render.camera import View
from particlecli.render.renderer import Renderer
from particlecli.scene.model import Scene
from particlecli.simulate import Simulation
from tests.benchmarks.dust import GROUP, Dust
from tests.benchmarks.figures import Figure

SLOWEST = 45.0
"""ms."""

GOES = 15


def measure() -> list[Figure]:
    """Milliseconds a picture: of glow dots in the air, and above a ground that mirrors them."""
    scene = Dust(frames=1).scene()
    simulation = Simulation(scene)
    *_, frame = simulation
    bare = scene.model_copy(update={"planes": ()})
    renderer, grounded = Renderer(bare), Renderer(scene)
    fields = {GROUP: renderer.needs(GROUP)}
    seconds = fastest(
        {
            "picture": lambda: renderer.render(simulation.system.frame(1, fields)),
            "grounded": lambda: grounded.render(simulation.system.frame(1, fields)),
            "NumPy, one pixel a dot": lambda: plain_dots(bare, frame),
        }
    )
    peer = {"NumPy, one pixel a dot": seconds["NumPy, one pixel a dot"] * 1e3}
    return [
        Figure("1M glow dots", seconds["picture"] * 1e3, "ms", "less", must=SLOWEST, peers=peer),
        Figure("1M glow dots above a ground", seconds["grounded"] * 1e3, "ms", "less"),
    ]


def fastest(tasks: dict[str, Callable[[], object]]) -> dict[str, float]:
    """The fastest of several goes at each task, s, the tasks in turn."""
    seconds: dict[str, list[float]] = {name: [] for name in tasks}
    for go in range(GOES + 1):
        for name, task in tasks.items():
            task()  # another one's arena is emptied and its caches are filled, as a video's first frame does
            began = time.perf_counter()
            task()
            if go:  # the first one compiles
                seconds[name].append(time.perf_counter() - began)
    return {name: min(times) for name, times in seconds.items()}


def plain_dots(scene: Scene, frame: Frame) -> NDArray[np.uint8]:
    """A picture the plain way: every particle lights one pixel, counted by `np.bincount`."""
    width, height = scene.camera.resolution
    positions = frame.groups[GROUP].positions
    view = View.of(scene.camera, width, height)
    offset = positions - view.position.astype(np.float32)
    right, up, forward = (axis.astype(np.float32) for axis in (view.right, view.up, view.forward))
    depth = offset @ forward
    focal = np.float32(view.focal)
    column = (width / 2 + focal * (offset @ right) / depth).astype(np.int32)
    row = (height / 2 - focal * (offset @ up) / depth).astype(np.int32)
    seen = (depth > 0) & (column >= 0) & (column < width) & (row >= 0) & (row < height)
    light = np.bincount(row[seen] * width + column[seen], minlength=width * height)
    shade = np.round(255 * (1 - np.exp(-0.3 * light))).astype(np.uint8)
    return np.repeat(shade.reshape(height, width, 1), 3, axis=2)

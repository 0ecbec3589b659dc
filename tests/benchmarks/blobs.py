"""A hundred thousand merging blobs at 1280×720: a heap of water, clear and opaque, beside a million glow dots."""

from __future__ import annotations

import numpy as np

from particlecli.frame import Frame, GroupFrame
from particlecli.render.renderer import Renderer
from particlecli.scene.model import Scene
from particlecli.simulate import Simulation
from tests.benchmarks.dust import GROUP, Dust
from tests.benchmarks.figures import Figure
from tests.benchmarks.render import fastest

COUNT = 100_000

SLOWEST = 100.0
"""ms."""

GLOW = "1M glow dots"


def measure() -> list[Figure]:
    """Milliseconds a picture: of clear water and of opaque wax."""
    dust = Dust(frames=1).scene()
    simulation = Simulation(dust)
    *_, sparks = simulation
    glow = Renderer(dust.model_copy(update={"planes": ()}))
    water, wax = Renderer(heap(opacity=0.05)), Renderer(heap(opacity=1.0))
    blobs = frame()
    seconds = fastest(
        {
            GLOW: lambda: glow.render(sparks),
            "water": lambda: water.render(blobs),
            "wax": lambda: wax.render(blobs),
        }
    )
    peer = {GLOW: 1e3 * seconds[GLOW]}
    return [
        Figure("100k blobs of clear water", 1e3 * seconds["water"], "ms", "less", must=SLOWEST, peers=peer),
        Figure("100k blobs of opaque wax", 1e3 * seconds["wax"], "ms", "less", must=SLOWEST, peers=peer),
    ]


def frame() -> Frame:
    """Blobs about as far apart as particles of a fluid, in a heap under a wave, 2 m wide."""
    random = np.random.default_rng(1)
    spacing = 0.0262
    axes = [np.arange(-0.5 * size, 0.5 * size, spacing) for size in (2.2, 1.6, 1.0)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    places += random.normal(scale=0.15 * spacing, size=places.shape)
    height = 0.15 * np.sin(4.0 * places[:, 0]) + 0.08 * np.sin(9.0 * places[:, 2])
    order = np.argsort(places[:, 1] - height, kind="stable")[:COUNT]
    places = places[np.sort(order)] + [0.0, 0.81, 0.0]
    stored = np.ascontiguousarray(places.T.astype(np.float32)).T
    return Frame(index=0, time=0.0, groups={GROUP: GroupFrame(ids=np.arange(COUNT), positions=stored)})


def heap(opacity: float) -> Scene:
    """The scene of the heap."""
    return Scene.model_validate(
        {
            "duration": 1,
            "particles": {GROUP: {"positions": [[0, 0, 0]]}},
            "camera": {"position": [0.6, 1.7, 4.4], "look_at": [0.0, 0.55, 0.0], "field_of_view": 34},
            "look": {"groups": {GROUP: {"as": "blobs", "radius": 0.024, "color": "#4aa0d8", "opacity": opacity}}},
        }
    )

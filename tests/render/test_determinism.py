from __future__ import annotations

import hashlib

import numpy as np

from particlecli import runtime
from particlecli.render.renderer import Renderer
from tests.render.frames import frame, group, scene

COUNT = 10_000


def digests(threads: int) -> set[str]:
    """Two pictures alike, with every look, a ground, bloom and enough particles for several chunks."""
    runtime.start("single", threads)
    random = np.random.default_rng(5)
    places = random.normal(size=(COUNT, 3)) * [0.6, 0.4, 0.6]
    dust = group(places, velocities=random.normal(size=(COUNT, 3)), temperatures=random.uniform(900, 1700, COUNT))
    styles = {
        "blobs": {"as": "blobs", "radius": 0.01, "opacity": 0.5, "liquid": {"stretch": 0.01}},
        "dots": {"as": "dots", "radius": 0.004, "brightness": 0.3},
        "glow": {"as": "glow", "radius": 0.01, "color": "blackbody", "brightness": 0.02},
        "spheres": {"as": "spheres", "radius": 0.006, "opacity": 0.4, "shadow": 0.1},
        "sprites": {"as": "sprites", "radius": 0.02, "spin": 0, "opacity": 0.3},
        "streaks": {
            "as": "streaks",
            "radius": 0.005,
            "color": {"by": "speed", "map": "ice", "range": [0, 3]},
        },
    }
    camera = {"position": [0, 0.5, 4], "look_at": [0, 0, 0]}
    planes = [{"point": [0, -0.7, 0]}]
    spec = scene(*styles, size=(160, 90), camera=camera, planes=planes, bloom=0.15, **styles)
    renderer = Renderer(spec)
    lit = frame(**dict.fromkeys(styles, dust))
    return {hashlib.sha256(renderer.render(lit).tobytes()).hexdigest() for _ in range(2)}


def test_pictures_do_not_depend_on_the_number_of_threads_nor_on_the_run() -> None:
    assert len(digests(2) | digests(1) | digests(3)) == 1

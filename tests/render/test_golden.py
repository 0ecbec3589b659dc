"""Small pictures of every look, compared with those in `golden/`.

After a change that is meant to show, look at the difference (its path is in the failure), then regenerate:

    python -m tests.render.test_golden
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from particlecli import runtime
from particlecli.dynamics.layouts import layout_count, layout_positions
from particlecli.dynamics.random import Draws
from particlecli.frame import Frame
from particlecli.render.renderer import Renderer
from particlecli.scene.groups import Particles
from particlecli.scene.model import Scene
from tests.render.frames import frame, group, scene

GOLDEN = Path(__file__).parent / "golden"
CAMERA = {"position": [0, 0.8, 3], "look_at": [0, 0.5, 0]}
TOLERANCE = 3
"""Other processors round differently; a value may be off by so much."""


def spiral(count: int = 60) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    turn = np.linspace(0, 6 * np.pi, count)
    radius = np.linspace(0.1, 0.9, count)
    places = np.stack([radius * np.cos(turn), 0.1 + turn / 20, radius * np.sin(turn)], axis=1)
    speeds = np.stack([-np.sin(turn), 0.4 + 0 * turn, np.cos(turn)], axis=1) * 4 * radius[:, None]
    return places, speeds


def picture(style: dict[str, Any], *, planes: bool = False, **look: Any) -> tuple[Scene, Frame]:
    places, speeds = spiral()
    age = np.linspace(0, 2, len(places))
    lit = group(places, velocities=speeds, ages=age, lifetimes=0 * age + 2, temperatures=1700 - 350 * age)
    return scene(camera=CAMERA, planes=[{}] * planes, bloom=0.15, **look, dust=style), frame(dust=lit)


def joined(layout: dict[str, Any], style: dict[str, Any]) -> tuple[Scene, Frame]:
    """Particles of a layout, on a wave."""
    spec = scene(camera=CAMERA, bloom=0.15, dust=style)
    dust = Particles.model_validate({"layout": layout})
    spec = spec.model_copy(update={"particles": {"dust": dust}})
    assert dust.layout is not None
    places = layout_positions(dust.layout, Draws(0, "dust", np.arange(layout_count(dust.layout)))).T
    places[:, 1] += 0.15 * np.sin(5 * places[:, 0] + 3 * places[:, 2])
    return spec, frame(dust=group(places))


PICTURES: dict[str, Callable[[], tuple[Scene, Frame]]] = {
    "dots": lambda: picture({"as": "dots", "radius": 0.05, "color": {"by": "id", "map": "turbo", "range": [0, 60]}}),
    "glow": lambda: picture({"as": "glow", "radius": 0.04, "color": {"by": "age", "map": "aurora"}}),
    "streaks": lambda: picture({"as": "streaks", "radius": 0.015, "color": "#9fd4ff", "brightness": 4}),
    "blackbody": lambda: picture({"radius": 0.03, "color": {"blackbody": 1400}}),
    "fading": lambda: picture({"radius": 0.03, "fade_in": 0.3, "fade_out": 0.3, "color": "#ffffff"}),
    "ground": lambda: picture({"radius": 0.03, "color": {"blackbody": 1400}}, planes=True),
    "spheres": lambda: picture(
        {"as": "spheres", "radius": 0.12, "color": {"by": "id", "map": "turbo", "range": [0, 60]}}, planes=True
    ),
    "shadows": lambda: picture(
        {"as": "spheres", "radius": 0.08, "color": "#ffb454", "shadow": 0.8},
        planes=True,
        background="#31405c",
        ground={"color": "#e8eef8", "brightness": 0.5},
    ),
    "glass": lambda: picture(
        {"as": "spheres", "radius": 0.2, "opacity": 0.05, "color": "#bfe4ff"}, background="#31405c"
    ),
    "blobs": lambda: picture(
        {"as": "blobs", "radius": 0.1, "color": "#d0482c", "shadow": 0.7, "liquid": {"stretch": 0.06}},
        planes=True,
        background="#31405c",
        ground={"color": "#e8eef8", "brightness": 0.5},
    ),
    "water": lambda: picture(
        {"as": "blobs", "radius": 0.16, "opacity": 0.1, "color": "#58b0e0", "liquid": {"merge": 1.5}},
        planes=True,
        background="#31405c",
    ),
    "mercury": lambda: picture({"as": "blobs", "radius": 0.14, "color": "#dfe4ec", "liquid": {"metal": 1}}),
    "lava": lambda: picture(
        {"as": "blobs", "radius": 0.14, "color": {"by": "age", "map": "inferno"}, "liquid": {"glow": 1.5}}
    ),
    "sprites": lambda: picture({"as": "sprites", "radius": 0.25, "spin": 1, "color": "#d8cfc4"}),
    "flakes": lambda: picture({"as": "sprites", "sheet": "snow", "radius": 0.15, "opacity": 0.7, "color": "#ffffff"}),
    "surface": lambda: joined(
        {"type": "grid", "counts": [12, 1, 10], "spacing": 0.13, "center": [0, 0.5, 0]},
        {"as": "surface", "color": "#c8324a"},
    ),
    "block": lambda: joined(
        {"type": "grid", "counts": [4, 4, 4], "spacing": 0.25, "center": [0.2, 0.5, 0]},
        {"as": "surface", "color": {"by": "id", "map": "viridis", "range": [0, 63]}},
    ),
    "rope": lambda: joined(
        {"type": "line", "start": [-1, 0.8, 0], "end": [1, 0.2, 0.6], "count": 9},
        {"as": "ribbons", "radius": 0.06, "color": "#c9a15a"},
    ),
    "hair": lambda: joined(
        {"type": "hair", "radius": 0.3, "center": [0, 0.5, 0], "strands": 300, "count": 6, "length": 0.4},
        {"as": "ribbons", "radius": 0.006, "color": "#a5672f"},
    ),
    "snow": lambda: picture(
        {"as": "dots", "pixels": 8},
        planes=True,
        background="#31405c",
        ground={"color": "#e8eef8", "brightness": 0.5, "reflection": 0.05},
    ),
}


def rendered(name: str) -> NDArray[np.uint8]:
    spec, lit = PICTURES[name]()
    return Renderer(spec).render(lit).copy()


def compared(golden: NDArray[np.uint8], image: NDArray[np.uint8]) -> Image.Image:
    """Golden, new and eight times their difference, side by side and enlarged."""
    difference = np.clip(128 + 8 * (image.astype(int) - golden), 0, 255).astype(np.uint8)
    strip = Image.fromarray(np.concatenate([golden, image, difference], axis=1))
    return strip.resize((strip.width * 5, strip.height * 5), Image.Resampling.NEAREST)


@pytest.mark.parametrize("name", PICTURES)
def test_pictures_are_as_they_were(name: str, tmp_path: Path) -> None:
    image = rendered(name)
    golden = np.asarray(Image.open(GOLDEN / f"{name}.png"))
    worst = int(np.abs(image.astype(int) - golden).max())
    if worst > TOLERANCE:
        compared(golden, image).save(tmp_path / f"{name}.png")
    assert worst <= TOLERANCE, f"golden, new and difference side by side: {tmp_path / f'{name}.png'}"


def main() -> None:
    runtime.start("single")
    GOLDEN.mkdir(exist_ok=True)
    for name in PICTURES:
        Image.fromarray(rendered(name)).save(GOLDEN / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from particlecli.frame import Frame
from particlecli.render.renderer import Renderer
from particlecli.scene.look_checks import look_problems
from particlecli.scene.model import Scene
from tests.render.frames import LEVEL, frame, group

GRID = {"type": "grid", "counts": [5, 5, 1], "spacing": 0.4}
LINE = {"type": "line", "start": [-1, 0, 0], "end": [1, 0, 0], "count": 5}
DIFFUSE = {"direction": [0, 0, 1], "sky": "#000000"}


def spec(particles: dict[str, Any], style: dict[str, Any], **parts: Any) -> Scene:
    return Scene.model_validate(
        {
            "duration": 1,
            "particles": {"dust": particles},
            "camera": {**LEVEL, "resolution": [64, 48]},
            "look": {"bloom": 0, "light": DIFFUSE, "groups": {"dust": {"color": "#ffffff", **style}}},
            **parts,
        }
    )


def sheet(depth: float = 0.0) -> Frame:
    across, up = np.meshgrid(np.linspace(-0.8, 0.8, 5), np.linspace(-0.8, 0.8, 5))
    return frame(dust=group(np.stack([across.ravel(), up.ravel(), np.full(25, depth)], axis=1)))


def test_a_surface_has_no_gaps_and_its_area() -> None:
    image = Renderer(spec({"layout": GRID}, {"as": "surface"})).light(sheet())[..., 0]
    pixels = 48 / (2 * 4 * np.tan(np.radians(20)))
    side = 1.6 * pixels
    inside = image[int(24 - side / 2) + 2 : int(24 + side / 2) - 1, int(32 - side / 2) + 2 : int(32 + side / 2) - 1]
    assert inside.min() > 0.9 * inside.max()
    assert image.sum() / inside.mean() == pytest.approx(side**2, rel=0.04)


@pytest.mark.parametrize(
    ("layout", "style", "places"),
    [
        (GRID, {"as": "surface"}, sheet().groups["dust"].positions),
        ({**LINE, "count": 25}, {"as": "ribbons", "radius": 0.1}, np.linspace([0, 0.8, 0], [0, -0.8, 0], 25)),
    ],
)
def test_a_plane_hides_what_is_below_it(layout: dict[str, Any], style: dict[str, Any], places: Any) -> None:
    free, cut = (
        Renderer(spec({"layout": layout}, style, planes=planes)).light(frame(dust=group(places)))
        for planes in ([], [{"point": [0, -0.2, 0]}])
    )
    lit = free[..., 0] > 0.3
    assert np.abs(cut - free)[:24][lit[:24]].max() < 0.02
    assert lit[35:].any()
    assert cut[35:][lit[35:]].max() < 0.1 * free.max()


def test_what_is_torn_out_of_a_surface_is_not_drawn() -> None:
    whole = sheet()
    dust = whole.groups["dust"]
    torn = frame(dust=group(np.delete(dust.positions, 12, axis=0), ids=np.delete(dust.ids, 12)))
    renderer = Renderer(spec({"layout": GRID}, {"as": "surface"}))
    assert renderer.light(whole)[24, 32, 0] > 0.5
    assert renderer.light(torn)[24, 32, 0] == 0


def test_a_ribbon_goes_through_its_particles_and_is_as_wide_as_its_diameter() -> None:
    places = np.stack([np.linspace(-1, 1, 5), np.zeros(5), np.zeros(5)], axis=1)
    image = Renderer(spec({"layout": LINE}, {"as": "ribbons", "radius": 0.2})).light(frame(dust=group(places)))
    width = (image[:, 32, 0] > 0.5 * image[:, 32, 0].max()).sum()
    assert width == pytest.approx(0.4 * 48 / (2 * 4 * np.tan(np.radians(20))), abs=1.5)
    assert (image[24, 18:46, 0] > 0.5).all()


def test_thin_ribbons_are_as_bright_as_they_are_wide() -> None:
    places = np.stack([np.linspace(-1, 1, 5), np.zeros(5), np.zeros(5)], axis=1)
    thick, thin = (
        Renderer(spec({"layout": LINE}, {"as": "ribbons", "radius": radius})).light(frame(dust=group(places))).sum()
        for radius in (0.006, 0.002)
    )
    assert thick / thin == pytest.approx(3, rel=0.1)


@pytest.mark.parametrize(
    ("look", "particles", "message"),
    [
        ("ribbons", {"layout": GRID}, "ribbons join the particles of"),
        ("ribbons", {"positions": [[0, 0, 0]]}, "ribbons join the particles of"),
        ("surface", {"layout": LINE}, "a surface is a skin over a `grid`"),
        ("surface", {"layout": {"type": "grid", "counts": [5, 1, 1], "spacing": 1}}, "a surface is a skin"),
    ],
)
def test_what_cannot_be_joined_is_refused(look: str, particles: dict[str, Any], message: str) -> None:
    ((path, told),) = look_problems(spec(particles, {"as": look}))
    assert path == ("look", "groups", "dust", "as")
    assert message in told

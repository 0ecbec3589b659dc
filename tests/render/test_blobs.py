from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from particlecli.errors import SceneError
from particlecli.render.liquids.room import room_for
from particlecli.render.renderer import Renderer
from particlecli.scene.load import load_scene
from tests.render.frames import LEVEL, frame, group, scene

RED, BLUE = "#ff0000", "#0000ff"
FLAT = {**LEVEL, "projection": "orthographic"}
BLOBS = {"as": "blobs", "radius": 0.4, "color": "#ffffff"}
SIZE = (96, 72)
METRES = 2 * 4 * np.tan(np.radians(20)) / SIZE[1]
"""Per pixel, at the origin."""


def light(*groups: str, planes: Any = (), **parts: Any) -> NDArray[np.float32]:
    """Of groups named in `groups`: their styles and their particles as `name` and `name_at`."""
    lit = frame(**{name: group(parts.pop(f"{name}_at")) for name in groups})
    return Renderer(scene(*groups, size=SIZE, camera=FLAT, planes=planes, **parts)).light(lit)


def surface(places: Any, *, velocities: Any = None, **liquid: float) -> tuple[NDArray[Any], NDArray[Any]]:
    """How much of each pixel is covered, and the depth there, m."""
    moving = {} if velocities is None else {"velocities": velocities}
    spec = scene(size=SIZE, camera=FLAT, dust={**BLOBS, "liquid": liquid})
    Renderer(spec).light(frame(dust=group(places, **moving)))
    kept = room_for(*SIZE).shape.to_numpy()[: SIZE[0] * SIZE[1]].reshape(SIZE[1], SIZE[0], 4)
    return kept[..., 0], kept[..., 3]


def marched(places: Any, merge: float) -> NDArray[np.float64]:
    """Depths of the surface by small steps along rays, in double precision; infinite where there is none.

    Blobs are half a pixel wider, see `ellipsoids.EDGE`.
    """
    narrow = (0.4 / METRES) / (0.4 / METRES + 0.5)
    support = 0.4 * (1 + merge)
    level = (1 - (1 + merge) ** -2) ** 8
    x = (np.arange(SIZE[0]) - (SIZE[0] - 1) / 2) * METRES
    y = ((SIZE[1] - 1) / 2 - np.arange(SIZE[1])) * METRES
    found = np.full((SIZE[1], SIZE[0]), np.inf)
    for z in np.arange(1.5, -1.5, -0.008):
        density = np.zeros_like(found)
        for place in places:
            across = (x[None] - place[0]) ** 2 + (y[:, None] - place[1]) ** 2
            square = narrow**2 * across + (z - place[2]) ** 2
            density += np.maximum(1 - square / support**2, 0) ** 8
        found = np.where(np.isinf(found) & (density >= level), 4 - z, found)
    return found


def test_one_blob_is_a_ball_of_its_radius() -> None:
    covered, depth = surface([[0, 0, 0]])
    assert covered.sum() * METRES**2 == pytest.approx(np.pi * 0.4**2, rel=0.03)
    assert depth[36, 48] == pytest.approx(4 - 0.4, abs=2e-3)
    assert len(np.unique(covered.round(3))) > 6


@pytest.mark.parametrize("merge", [0.4, 1.0, 2.5])
def test_the_surface_is_where_the_density_of_all_blobs_says(merge: float) -> None:
    places = np.random.default_rng(8).uniform([-0.9, -0.6, -0.6], [0.9, 0.6, 0.6], (14, 3))
    covered, depth = surface(places, merge=merge)
    expected = marched(places, merge)
    there = np.isfinite(expected)
    assert ((covered > 0) == there).mean() > 0.98
    both = there & (covered == 1)
    off = np.abs(depth - expected)[both]
    assert np.median(off) < 0.006
    assert (off < 0.03).mean() > 0.97


def test_blobs_near_each_other_merge_and_farther_ones_do_not() -> None:
    near, _ = surface([[-0.43, 0, 0], [0.43, 0, 0]])
    far, _ = surface([[-0.6, 0, 0], [0.6, 0, 0]])
    assert near[36, 47] > 0.5
    assert far[:, 47].max() == 0


def test_moving_blobs_are_drawn_out_along_their_velocity() -> None:
    def extents(velocity: list[float]) -> tuple[int, int]:
        covered, _ = surface([[0, 0, 0]], velocities=[velocity], stretch=0.8)
        return int((covered.max(axis=0) > 0.5).sum()), int((covered.max(axis=1) > 0.5).sum())

    wide, flat = extents([1, 0, 0])
    thin, tall = extents([0, -1, 0])
    assert wide > 2 * flat
    assert (thin, tall) == pytest.approx((flat, wide), abs=1)
    turned, same = extents([0, 0, 1])
    assert turned == pytest.approx(flat, abs=1) == same


def test_a_tilted_blob_reaches_where_its_ellipsoid_does() -> None:
    """Its shadow along z: half of its height is √(b² + (a² − b²) u²) for its half axes a, b and direction u."""
    covered, _ = surface([[0, 0, 0]], velocities=[[0.6, 0.8, 0.0]], stretch=0.8)
    ratio = 1 + 0.8 / 0.8
    long, short = 0.4 * ratio, 0.4 / np.sqrt(ratio)
    high = 2 * np.sqrt(short**2 + (long**2 - short**2) * 0.64) / METRES
    assert (covered.max(axis=1) > 0.5).sum() == pytest.approx(high, abs=2)


def test_blobs_and_balls_hide_each_other_by_depth() -> None:
    styles = {"blobs": {**BLOBS, "color": BLUE}, "ball": {"as": "spheres", "radius": 0.2, "color": RED}}
    before = light("blobs", "ball", **styles, blobs_at=[[0, 0, 0]], ball_at=[[0, 0, 1]])[36, 48]
    behind = light("blobs", "ball", **styles, blobs_at=[[0, 0, 0]], ball_at=[[0, 0, -1]])[36, 48]
    assert before[0] > 3 * before[2]
    assert behind[2] > 3 * behind[0]


def test_clear_liquids_show_what_is_behind_and_hide_more_where_they_are_thick() -> None:
    def red(count: int, opacity: float) -> float:
        water = {**BLOBS, "color": BLUE, "opacity": opacity}
        ball = {"as": "spheres", "radius": 0.3, "color": RED}
        places = [[0, 0, -0.3 * k] for k in range(count)]
        image = light("water", "ball", water=water, ball=ball, water_at=places, ball_at=[[0, 0, -3]])
        return float(image[36, 48, 0])

    assert red(1, 0.0) > 1.5 * red(1, 0.5) > 2 * red(3, 0.5)


def test_light_behind_a_liquid_is_hidden() -> None:
    styles = {"wax": {**BLOBS, "color": "#000000"}, "spark": {"as": "glow", "pixels": 20, "color": "#ffffff"}}
    alone = light("wax", wax=styles["wax"], wax_at=[[0, 0, 0]])
    behind = light("wax", "spark", **styles, wax_at=[[0, 0, 0]], spark_at=[[0, 0, -1]])
    before = light("wax", "spark", **styles, wax_at=[[0, 0, 0]], spark_at=[[0, 0, 1]])
    assert np.abs(behind - alone).sum() < 0.02 * (before - alone).sum()


def test_planes_hide_what_is_below_them() -> None:
    camera = {"position": [0, 0.5, 4], "look_at": [0, 0, 0]}
    ground = {"brightness": 0, "reflection": 0}
    parts = {"size": SIZE, "camera": camera, "dust": BLOBS, "ground": ground}
    lit = frame(dust=group([[0, 0, 0]]))
    whole, half = (Renderer(scene(planes=planes, **parts)).light(lit) for planes in ([], [{}]))
    middle = int(np.argmax(whole[:, 48].sum(axis=1) > 0)) + 10
    assert half[:middle] == pytest.approx(whole[:middle], abs=1e-6)
    assert half[43:].sum() < 0.05 * whole[43:].sum()


def test_a_metal_mirrors_and_lava_glows() -> None:
    dark = {"light": {"brightness": 0, "sky": "#000000"}, "dust_at": [[0, 0, 0]]}
    lava = light("dust", dust={**BLOBS, "color": RED, "liquid": {"glow": 2}}, **dark)[36, 48]
    assert lava[0] > 1 > 100 * lava[2]
    day = {"light": {"brightness": 0, "sky": "#ffffff"}, "dust_at": [[0, 0, 0]]}
    gold = light("dust", dust={**BLOBS, "color": "#ffff00", "liquid": {"metal": 1}}, **day)[36, 48]
    assert gold[0] > 0.3 > 10 * gold[2]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("as: glow, liquid: {merge: 1}", "goes with `as: blobs`"),
        ("as: blobs, liquid: {merge: 9}", "must be at most 3"),
        ("as: blobs, liquid: {stretch: 0.1}", "has no velocity to draw blobs out along"),
    ],
)
def test_bad_liquids_are_told(tmp_path: Any, words: str, message: str) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(
        "duration: 1\nflows: {air: [{type: uniform, velocity: [1, 0, 0]}]}\n"
        f"particles: {{dust: {{motion: first_order, flow: air, positions: [[0, 0, 0]]}}}}\n"
        f"look: {{groups: {{dust: {{{words}}}}}}}\n"
    )
    with pytest.raises(SceneError, match=message):
        load_scene(path)

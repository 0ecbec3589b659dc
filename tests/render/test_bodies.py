from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from particlecli.errors import SceneError
from particlecli.render.renderer import Renderer
from particlecli.scene.load import load_scene
from tests.render.frames import frame, group, scene

RED, BLUE = "#ff0000", "#0000ff"
SPHERE = {"as": "spheres", "radius": 0.5}


def light(*groups: str, planes: Any = (), **parts: Any) -> NDArray[np.float32]:
    """Of groups named in `groups`: their styles and their particles as `name` and `name_at`."""
    lit = frame(**{name: group(**parts.pop(f"{name}_at")) for name in groups})
    return Renderer(scene(*groups, planes=planes, **parts)).light(lit)


def at(*places: list[float], **fields: Any) -> dict[str, Any]:
    return {"positions": list(places), **fields}


@pytest.mark.parametrize("first", ["near", "far"])
def test_the_nearer_sphere_hides_the_farther_in_whatever_order_they_come(first: str) -> None:
    names = ("near", "far") if first == "near" else ("far", "near")
    styles = {"near": {**SPHERE, "color": RED}, "far": {**SPHERE, "color": BLUE}}
    image = light(*names, **styles, near_at=at([0, 0, 1]), far_at=at([0, 0, -1]))
    middle = image[24, 32]
    assert middle[0] > 0.3
    assert middle[2] < 0.3 * middle[0]


def test_spheres_are_lit_from_where_the_light_is() -> None:
    lit = {"light": {"direction": [1, 0, 0], "sky": "#000000"}}
    image = light("dust", dust={**SPHERE, "color": "#ffffff"}, dust_at=at([0, 0, 0]), **lit)
    assert image[24, 36:].sum() > 3 * image[24, :28].sum()


def test_spheres_hide_light_behind_them_and_not_before_them() -> None:
    parts = {"ball": {**SPHERE, "color": "#000000"}, "spark": {"as": "glow", "pixels": 30, "color": "#ffffff"}}
    behind = light("ball", "spark", **parts, ball_at=at([0, 0, 0]), spark_at=at([0, 0, -1]))
    before = light("ball", "spark", **parts, ball_at=at([0, 0, 0]), spark_at=at([0, 0, 1]))
    alone = light("ball", ball=parts["ball"], ball_at=at([0, 0, 0]))
    assert np.abs(behind - alone).sum() < 0.01 * (before - alone).sum()


def test_what_opacity_lets_through_is_seen() -> None:
    def through(opacity: float) -> float:
        glass = {**SPHERE, "opacity": opacity, "color": "#ffffff"}
        back = {**SPHERE, "radius": 0.2, "color": RED}
        image = light("glass", "back", glass=glass, back=back, glass_at=at([0, 0, 1]), back_at=at([0, 0, -1]))
        return float(image[24, 32, 0] - image[24, 32, 2])

    assert through(0.0) > 2 * through(0.7)
    assert through(0.7) > 2 * through(1.0)


def test_edges_are_antialiased_and_areas_right() -> None:
    """The light of a sphere of uniform colour grows with its area, however small it is."""
    areas = []
    for pixels in (2.0, 6.0, 16.0):
        style = {"as": "spheres", "pixels": pixels * 15, "color": "#ffffff"}
        image = light("dust", dust=style, dust_at=at([0.013, 0.007, 0]))
        areas.append(float(image.sum()) / pixels**2)
        assert len(np.unique(image[..., 0].round(3))) > 6
    assert areas == pytest.approx([areas[1]] * 3, rel=0.15)


def test_sprites_show_the_picture_of_their_age(tmp_path: Path) -> None:
    sheet = np.zeros((8, 16, 4), np.uint8)
    sheet[:, :8], sheet[:, 8:] = (255, 0, 0, 255), (0, 0, 255, 255)
    Image.fromarray(sheet).save(tmp_path / "sheet.png")
    renderer = Renderer(_sprites(tmp_path, "{sheet: sheet.png, grid: [2, 1], pixels: 200}"))
    young, old = (
        renderer.light(frame(dust=group([[0, 0, 0]], ages=[age], lifetimes=[2])))[24, 32] for age in (0.5, 1.5)
    )
    assert young[0] > 0.5 > 10 * young[2]
    assert old[2] > 0.5 > 10 * old[0]


def test_pictures_follow_one_another_over_and_over(tmp_path: Path) -> None:
    sheet = np.zeros((8, 16, 4), np.uint8)
    sheet[:, :8], sheet[:, 8:] = (255, 0, 0, 255), (0, 0, 255, 255)
    Image.fromarray(sheet).save(tmp_path / "sheet.png")
    renderer = Renderer(_sprites(tmp_path, "{sheet: sheet.png, grid: [2, 1], sheet_rate: 4, pixels: 200}"))
    assert "ages" in renderer.needs("dust")
    seen = [
        renderer.light(frame(dust=group([[0, 0, 0]], ages=[age], lifetimes=[9])))[24, 32].argmax()
        for age in (0.0, 0.25, 0.5, 0.75, 1.0)
    ]
    assert seen[0] != seen[1]
    assert seen == [*seen[:2], *seen[:2], seen[0]]


@pytest.mark.parametrize(
    ("options", "content", "message"),
    [
        ("{sheet: none.png}", None, 'there is no file "none.png" in the scene\'s folder'),
        ("{sheet: sheet.png}", b"no image", "is no image that can be read"),
        ("{sheet: sheet.png}", b"\x89PNG\r\n\x1a\n\0\0", "is no image that can be read"),
        ("{sheet: sheet.png, grid: [9, 1]}", (4, 4), "no room for 9 × 1 pictures: it is 4 × 4"),
    ],
)
def test_bad_sheets_are_told_with_their_place(tmp_path: Path, options: str, content: Any, message: str) -> None:
    if isinstance(content, bytes):
        (tmp_path / "sheet.png").write_bytes(content)
    elif content:
        Image.new("RGBA", content).save(tmp_path / "sheet.png")
    with pytest.raises(SceneError, match=message) as caught:
        Renderer(_sprites(tmp_path, options))
    assert "scene.yaml:6:" in str(caught.value)
    assert caught.value.exit_code == 2


def _sprites(folder: Path, options: str) -> Any:
    path = folder / "scene.yaml"
    options = "{as: sprites, color: '#ffffff', " + options.removeprefix("{")
    path.write_text(
        "duration: 1\nemitters: {dust: {rate: 1, lifetime: 2}}\ncamera: {position: [0, 0, 4], look_at: [0, 0, 0],\n"
        f"  resolution: [64, 48]}}\nlook:\n  groups: {{dust: {options}}}\n"
    )
    return load_scene(path)

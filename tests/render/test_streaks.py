from __future__ import annotations

import numpy as np
import pytest

from particlecli.frame import Frame
from particlecli.render.renderer import Renderer
from tests.render.frames import centroid, frame, group, scene
from tests.render.test_glow import SIZE, place

SECONDS = 0.5 / 30


@pytest.fixture(autouse=True)
def _no_halo(monkeypatch: pytest.MonkeyPatch) -> None:
    from particlecli.render.looks.streaks import Streaks

    monkeypatch.setattr(Streaks, "halo", 0.0)


def streaks(pixels: float = 1.0, **style: object) -> Renderer:
    look = {"as": "streaks", "pixels": pixels * 6, "shutter": 0.5, "color": "#ffffff", **style}
    return Renderer(scene(size=SIZE, dust=look))


def moving(renderer: Renderer, length: float, angle: float = 0.0, **fields: list[float]) -> Frame:
    """A particle at pixel (100, 60) that moved `length` pixels while the shutter was open."""
    speed = length * 4 / renderer.view.focal / SECONDS
    velocity = [speed * np.cos(angle), speed * np.sin(angle), 0.0]
    return frame(dust=group([place(renderer.view, 100, 60)], velocities=[velocity], **fields))


@pytest.mark.parametrize("length", [0.0, 5.0, 23.0, 70.0])
@pytest.mark.parametrize("angle", [0.0, 0.6, 2.2])
def test_length_place_and_energy(length: float, angle: float) -> None:
    """Back from where the particle is; an even line's variance along itself is length²/12."""
    renderer = streaks()
    light = renderer.light(moving(renderer, length, angle))
    assert light[..., 0].sum() == pytest.approx(np.pi, rel=0.01)
    across, down = np.cos(angle) * length / 2, -np.sin(angle) * length / 2
    assert centroid(light) == pytest.approx((100 - across, 60 - down), abs=0.02)
    rows, columns = np.indices(light.shape[:2])
    along = (columns - 100) * np.cos(angle) - (rows - 60) * np.sin(angle)
    total = light[..., 0].astype(np.float64)
    mean = (total * along).sum() / total.sum()
    variance = (total * (along - mean) ** 2).sum() / total.sum()
    assert np.sqrt(12 * max(variance - 0.5, 0)) == pytest.approx(length, rel=0.02, abs=0.1)


@pytest.mark.parametrize("pixels", [0.5, 1.5, 3.0, 6.0])
def test_even_along_the_line(pixels: float) -> None:
    renderer = streaks(pixels)
    line = renderer.light(moving(renderer, 60.0))[..., 0].sum(axis=0)[56:85]
    assert line == pytest.approx([line.mean()] * len(line), rel=0.02)


def test_nothing_is_smeared_before_birth() -> None:
    renderer = streaks()
    whole, young = (renderer.light(moving(renderer, 40.0, ages=[age])) for age in (1.0, SECONDS / 4))
    assert centroid(young)[0] == pytest.approx(100 - 5, abs=0.05)
    assert young.sum() == pytest.approx(whole.sum() / 4, rel=0.01)


def test_a_path_from_behind_the_camera_is_cut_off() -> None:
    renderer = Renderer(scene(size=SIZE, dust={"as": "streaks", "radius": 0.01, "shutter": 1.0}))
    light = renderer.light(frame(dust=group([[0.1, 0, 2]], velocities=[[0, 0, -200]])))
    assert np.isfinite(light).all()
    assert light.sum() > 0


def test_streaks_ask_for_velocities() -> None:
    assert streaks().needs("dust") == {"velocities", "ages"}
    with pytest.raises(ValueError, match="velocities"):
        streaks().render(frame(dust=group([[0, 0, 0]])))

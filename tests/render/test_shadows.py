from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from particlecli.render.renderer import Renderer
from tests.render.frames import frame, group, scene

SIZE = (96, 72)
ABOVE = {"position": [0, 6, 0], "look_at": [0, 0, 0], "up": [0, 0, -1]}
GROUND = {"color": "#ffffff", "brightness": 0.6, "reflection": 0, "haze": 1000}


def picture(places: Any, *, shadow: float, **options: Any) -> NDArray[np.int64]:
    """A plane seen from above; the dust itself lights next to nothing."""
    style = {"as": "dots", "radius": 0.4, "brightness": 0, "shadow": shadow, **options.pop("style", {})}
    spec = scene(size=SIZE, camera=ABOVE, planes=[{}], ground=GROUND, dust=style, **options)
    return Renderer(spec).render(frame(dust=group(places))).astype(int).sum(axis=2)


def darkest(image: NDArray[np.int64]) -> tuple[int, int]:
    row, column = np.unravel_index(int(np.argmin(image)), image.shape)
    return int(row), int(column)


def test_a_shadow_lies_where_the_light_is_hidden() -> None:
    pixels = 72 / (2 * 6 * np.tan(np.radians(20)))
    image = picture([[0, 1, 0]], shadow=0.9, light={"direction": [1, 1, 0]})
    row, column = darkest(image)
    assert column == pytest.approx(47.5 - pixels, abs=2)
    assert row == pytest.approx(35.5, abs=2)


@pytest.mark.slow
def test_shadows_are_as_deep_as_asked_for() -> None:
    light = {"direction": [0, 1, 0]}
    lit, half, dark = (picture([[0, 0.4, 0]], shadow=shadow, light=light).min() for shadow in (0.0, 0.4, 0.95))
    assert lit > half > dark
    assert dark < 0.35 * lit


def test_shadows_soften_with_height() -> None:
    light = {"direction": [0, 1, 0]}
    low, high = (picture([[0, height, 0]], shadow=0.8, light=light) for height in (0.4, 4.0))
    assert high.min() > low.min()
    assert (high < high.max() - 10).sum() > (low < low.max() - 10).sum()


def test_no_shadow_falls_where_the_light_does_not_reach() -> None:
    below = picture([[0, 1, 0]], shadow=0.9, light={"direction": [0, -1, 0]})
    assert np.array_equal(below, picture([[0, 1, 0]], shadow=0.0))

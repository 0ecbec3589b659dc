from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from particlecli.render.colour import encode, from_hex
from particlecli.render.palettes import GROUP_COLORS, PALETTES, blend, colormap


@pytest.mark.parametrize("name", PALETTES)
def test_ends_are_the_palettes_own(name: str) -> None:
    stops = PALETTES[name].split()
    table = colormap(name, 256)
    assert table.shape == (256, 3)
    assert table[[0, -1]] == pytest.approx(from_hex([stops[0], stops[-1]]), abs=1e-5)


@pytest.mark.parametrize("name", ["inferno", "magma", "plasma", "viridis", "turbo", "coolwarm", "twilight"])
def test_baked_palettes_are_matplotlibs(name: str) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    theirs = matplotlib.colormaps[name](np.linspace(0, 1, 256))[:, :3]
    assert np.abs(encode(colormap(name, 256)) - theirs).max() < 0.06


def test_blending_is_even_to_the_eye() -> None:
    middle = encode(blend(["#000000", "#ffffff"], 3)[1])
    assert middle == pytest.approx([0.3886] * 3, abs=1e-3)  # Oklab lightness ½


def test_group_colours_can_be_told_apart() -> None:
    colors = encode(from_hex(GROUP_COLORS))
    for first, second in pairwise(colors):
        assert np.abs(first - second).max() > 0.15

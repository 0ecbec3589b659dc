from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from particlecli.render.colour import LUMINANCE, decode, encode, from_hex, from_oklab, into_gamut, to_oklab


@given(st.floats(0, 1))
def test_encoding_undoes_decoding(value: float) -> None:
    assert encode(decode(value)) == pytest.approx(value, abs=1e-6)


def test_hex_is_decoded() -> None:
    assert from_hex("#ff8000") == pytest.approx([1.0, 0.2158605, 0.0])
    assert from_hex(["#000000", "#ffffff"]) == pytest.approx(np.array([[0.0] * 3, [1.0] * 3]))


def test_oklab_of_white_is_grey_of_lightness_one() -> None:
    assert to_oklab(np.ones(3)) == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)


@given(arrays(np.float64, 3, elements=st.floats(0, 4)))
def test_oklab_goes_there_and_back(color: np.ndarray) -> None:
    assert from_oklab(to_oklab(color)) == pytest.approx(color, abs=1e-6)


@given(arrays(np.float64, 3, elements=st.floats(-1, 4)))
def test_into_gamut_keeps_luminance_and_leaves_nothing_negative(color: np.ndarray) -> None:
    if color @ LUMINANCE <= 1e-6:
        return
    inside = into_gamut(color)
    assert (inside >= 0).all()
    assert inside @ LUMINANCE == pytest.approx(color @ LUMINANCE, rel=1e-6)
    if (color >= 0).all():
        assert inside == pytest.approx(color)

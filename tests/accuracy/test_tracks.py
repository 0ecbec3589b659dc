"""Distances between records of particles: over particles, frames and groups, in metres and on the picture."""

import numpy as np
import pytest

from particlecli.accuracy.tracks import Track, deviation, found, spread_by_frame
from particlecli.render.camera import View, on_picture
from particlecli.scene.camera import Camera

VIEW = View.of(Camera(position=(0, 0, 10), look_at=(0, 0, 0), field_of_view=40), 1280, 720)


def track(positions):
    positions = np.array(positions, dtype=np.float64)
    return Track(np.arange(positions.shape[1]), positions, None)


def test_found_tells_which_numbers_are_there_and_where():
    here, there = found(np.array([1, 4, 5, 9]), np.array([0, 1, 2, 5, 6]))
    np.testing.assert_array_equal(here, [True, False, True, False])
    np.testing.assert_array_equal(there, [1, 3])
    here, there = found(np.array([3]), np.array([], dtype=np.int64))
    assert not here.any()
    assert len(there) == 0


def test_spread_is_over_those_that_are_there():
    distances = np.vstack([np.arange(1.0, 101.0), np.full(100, np.nan), np.r_[3.0, 4.0, np.full(98, np.nan)]])
    rms, p95, largest = spread_by_frame(distances).T
    np.testing.assert_allclose(rms, [np.sqrt(338350 / 100), np.nan, np.sqrt(12.5)])
    np.testing.assert_array_equal(p95, [95.0, np.nan, 4.0])
    np.testing.assert_array_equal(largest, [100.0, np.nan, 4.0])


def test_deviation_is_that_of_the_worst_frame_and_of_the_worst_group():
    still = np.zeros((3, 2, 3))
    moved = still.copy()
    moved[1, 0] = [0, 3, 4]
    moved[2, 0] = [1, 0, 0]
    slightly = still + np.array([0, 0.1, 0])
    result = deviation({"a": track(moved), "b": track(slightly)}, {"a": track(still), "b": track(still)}, VIEW)
    assert result.worst.largest == 5.0
    assert result.worst.rms == pytest.approx(np.sqrt(12.5))
    assert result.final.largest == 1.0
    assert result.final.rms == pytest.approx(np.sqrt(0.5))
    assert result.unmatched == 0.0
    only_b = deviation({"b": track(slightly)}, {"b": track(still)}, VIEW)
    assert only_b.worst.largest == pytest.approx(0.1)


def test_the_final_frame_is_the_last_with_something_to_compare():
    positions = np.zeros((4, 2, 3))
    positions[3] = np.nan
    positions[2, 1] = np.nan
    moved = positions.copy()
    moved[2, 0] = [0, 0, 2]
    moved[1, 1] = np.nan
    result = deviation({"a": track(moved)}, {"a": track(positions)}, VIEW)
    assert result.final.largest == 2.0
    assert result.unmatched == pytest.approx(1 / 5)
    with pytest.raises(ValueError, match="no particle is alive"):
        deviation({"a": track(positions[3:])}, {"a": track(positions[3:])}, VIEW)


def test_pixels_are_those_of_the_projection_of_small_offsets():
    rng = np.random.default_rng(1)
    positions = rng.uniform(-2, 2, (200, 3))
    offset = 1e-6 * rng.normal(size=(200, 3))
    here, _ = VIEW.project(positions)
    there, _ = VIEW.project(positions + offset)
    np.testing.assert_allclose(
        on_picture(positions, offset, VIEW), np.linalg.norm(there - here, axis=1), rtol=1e-5, atol=1e-9
    )


def test_what_is_not_on_the_picture_has_no_pixels():
    outside = [[0, 0, 11], [0, 0, 10], [100, 0, 0], [0, -4, 0], [np.nan, 0, 0]]
    pixels = on_picture(np.array([*outside, [0, 3, 0]]), np.ones((6, 3)), VIEW)
    np.testing.assert_array_equal(np.isnan(pixels), [True] * 5 + [False])
    assert deviation({"a": track([[[0, 0, 11]]])}, {"a": track([[[0, 0, 12]]])}, VIEW).worst_pixels is None

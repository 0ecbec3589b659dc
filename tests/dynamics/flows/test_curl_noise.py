"""Turbulence: a curl, free of divergence, of the speed, spectrum and lifetime that were asked for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from particlecli.dynamics.flows.curl_noise import MODES_PER_OCTAVE, modes
from particlecli.scene.flows import CurlNoiseFlow
from tests.dynamics.harness import rounded, velocity

RANDOM = np.random.default_rng(31)
STEP = 1e-5


def noise(**parts):
    return CurlNoiseFlow.model_validate({"type": "curl_noise", "length": 0.5, "speed": 0.6, "lifetime": 0.7, **parts})


def potential(table, x, t):
    """ψ at points of shape (3, n) and times of shape (n,), of which the flow is the curl."""
    k, frequency, phase, c = table[:, :3], table[:, 3], table[:, 4], table[:, 5:]
    size2 = (k**2).sum(axis=1, keepdims=True)
    angle = 2 * np.pi * (k @ x + np.outer(frequency, t) + phase[:, None])
    return (np.cross(c, k) / (2 * np.pi * size2)).T @ np.sin(angle)


def slopes(field, x):
    """∂field_i/∂x_j by central differences: shape (3, 3, n)."""
    ways = STEP * np.eye(3)[:, :, None]
    return np.stack([(field(x + way) - field(x - way)) / (2 * STEP) for way in ways], axis=1)


@pytest.fixture(scope="module")
def places():
    return RANDOM.uniform(-3, 3, (3, 400)), RANDOM.uniform(0, 5, 400)


def test_the_flow_is_the_curl_of_a_potential(places):
    x, t = places
    spec = noise()
    d = slopes(lambda at: potential(modes(spec, 9), at, t), x)
    curl = np.stack([d[2, 1] - d[1, 2], d[0, 2] - d[2, 0], d[1, 0] - d[0, 1]])
    found = velocity("double", spec, x, t, scene_seed=9)
    np.testing.assert_allclose(found, curl, atol=1e-7)
    assert np.abs(found - 0.99 * curl).max() > 1e-3


def test_it_has_no_divergence(places):
    x, t = places
    d = slopes(lambda at: velocity("double", noise(), at, t), x)
    assert np.abs(d[0, 0]).max() > 1
    assert np.abs(d[0, 0] + d[1, 1] + d[2, 2]).max() < 1e-6


def test_single_precision_agrees_with_double(places):
    x, t = rounded(places[0], "single"), rounded(places[1], "single")
    found, right = (velocity(precision, noise(), x, t) for precision in ("single", "double"))
    assert np.abs(found - right).max() < 2e-5


@pytest.mark.parametrize("octaves", [1, 4])
def test_root_mean_square_speed_is_what_was_asked_for_and_even_in_all_directions(octaves):
    x, t = RANDOM.uniform(-500, 500, (3, 40_000)), RANDOM.uniform(0, 500, 40_000)
    squares = (velocity("double", noise(octaves=octaves), x, t) ** 2).mean(axis=1)
    assert np.sqrt(squares.sum()) == pytest.approx(0.6, rel=0.01)
    np.testing.assert_allclose(squares, 0.12, rtol=0.05)


def test_neighbours_differ_by_the_cube_root_of_their_distance():
    """Kolmogorov's law of two thirds for the mean square, over the middle of the range of scales."""
    spec = noise(length=1, octaves=8, lifetime=None)
    x, t = RANDOM.uniform(-50, 50, (3, 20_000)), np.zeros(20_000)
    way = RANDOM.standard_normal((3, 20_000))
    way /= np.linalg.norm(way, axis=0)
    here = velocity("double", spec, x, t)
    distances = np.geomspace(1 / 16, 1 / 4, 5)
    squares = [((velocity("double", spec, x + r * way, t) - here) ** 2).sum(axis=0).mean() for r in distances]
    slope = np.polyfit(np.log(distances), np.log(squares), 1)[0]
    assert slope == pytest.approx(2 / 3, abs=0.12)


def correlation(spec, lag):
    x, t = RANDOM.uniform(-50, 50, (3, 20_000)), np.zeros(20_000)
    before, after = velocity("double", spec, x, t), velocity("double", spec, x, t + lag)
    return (before * after).sum() / (before**2).sum()


def test_eddies_change_within_their_lifetime():
    spec = noise(octaves=1)
    assert correlation(spec, 0.07) == pytest.approx(np.exp(-2 * np.pi**2 * 0.01), abs=0.05)
    assert correlation(spec, 0.175) == pytest.approx(np.exp(-2 * np.pi**2 / 16), abs=0.15)
    assert abs(correlation(spec, 0.7)) < 0.3
    assert correlation(noise(octaves=1, lifetime=1.4), 0.175) > 0.6


def test_without_a_lifetime_it_is_frozen():
    assert correlation(noise(lifetime=None), 1e3) == 1


@settings(max_examples=50, deadline=None)
@given(
    st.floats(1e-3, 1e3),
    st.just(0.0) | st.floats(1e-6, 1e3),
    st.integers(1, 8),
    st.none() | st.floats(1e-3, 1e3),
    st.integers(0, 2**70),
)
def test_waves_of_any_turbulence(length, speed, octaves, lifetime, seed):
    spec = noise(length=length, speed=speed, octaves=octaves, lifetime=lifetime, seed=seed)
    table = modes(spec, seed // 3)
    k, c = table[:, :3], table[:, 5:]
    wavelength = 1 / np.linalg.norm(k, axis=1)
    octave = np.repeat(np.arange(octaves), MODES_PER_OCTAVE)
    assert table.shape == (octaves * MODES_PER_OCTAVE, 8)
    assert np.abs(np.log2(wavelength / length) + octave).max() <= 0.5 + 1e-9
    assert np.abs((k * c).sum(axis=1)).max() <= 1e-14 * speed / wavelength.min()
    assert np.sqrt((c**2).sum() / 2) == pytest.approx(speed)
    np.testing.assert_allclose((c**2).sum(axis=1), (c[0] ** 2).sum() * (wavelength / wavelength[0]) ** (2 / 3))
    np.testing.assert_allclose(c.T @ c, np.eye(3) * (2 / 3) * speed**2, atol=0.02 * speed**2)
    changes = table[:, 3] * (lifetime or 1.0) * (wavelength / length) ** (2 / 3)
    spread = changes.reshape(octaves, MODES_PER_OCTAVE).std(axis=1)
    np.testing.assert_allclose(spread, 0 if lifetime is None else 1, atol=0.1)


def test_another_seed_is_another_turbulence():
    tables = [modes(noise(seed=seed), scene_seed) for seed, scene_seed in [(0, 0), (1, 0), (0, 1), (1, 1)]]
    phases = np.stack([table[:, 4] for table in tables])
    assert len(np.unique(phases)) == phases.size


def test_a_seed_means_the_same_turbulence_for_ever():
    """Written down when it was made: with other numbers every scene with turbulence would look different."""
    table = modes(noise(), 7)
    row = [
        -2.40930443,
        0.82598009,
        -1.63199572,
        -3.25956065,
        0.31506632,
        -0.07677633,
        -0.11566536,
        0.05480422,
    ]
    np.testing.assert_allclose(table[[0, 17, 35], 4], [0.5473505315, 0.3150663180, 0.3673026418], rtol=1e-9)
    np.testing.assert_allclose(table[17], row, rtol=2e-7)

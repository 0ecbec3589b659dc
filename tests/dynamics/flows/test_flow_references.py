"""Flows against their formulas, written again in NumPy."""

import typing

import numpy as np
import pytest
from pydantic import TypeAdapter

from particlecli.dynamics.flows import FlowTerm, flow_term, flow_terms
from particlecli.scene import flows as scene
from tests.dynamics.harness import EPSILON, gradient, rounded, velocity

RANDOM = np.random.default_rng(30)
PLACES = RANDOM.uniform(-2, 2, (3, 2000))
TIMES = RANDOM.uniform(0, 3, 2000)


WAVES = ("abc", "double_gyre", "taylor_green")


def spec(**parts):
    return TypeAdapter(scene.FlowTerm).validate_python(parts)


@pytest.fixture(scope="module", params=["single", "double"])
def precision(request):
    return request.param


def uniform(x, t, velocity):
    return np.broadcast_to(np.array(velocity)[:, None], x.shape)


def vortex(x, t, circulation, core, center=(0, 0, 0), axis=(0, 1, 0)):
    axis = np.array(axis) / np.linalg.norm(axis)
    d = x - np.array(center)[:, None]
    rho = d - axis[:, None] * (axis @ d)
    r = np.linalg.norm(rho, axis=0)
    speed = circulation / (2 * np.pi * r) * -np.expm1(-((r / core) ** 2))
    return speed * np.cross(axis, (rho / r).T).T


def abc(x, t, amplitudes=(1, 1, 1), wave_number=1.0):
    a, b, c = amplitudes
    sines, cosines = np.sin(wave_number * x), np.cos(wave_number * x)
    return np.stack(
        [
            a * sines[2] + c * cosines[1],
            b * sines[0] + a * cosines[2],
            c * sines[1] + b * cosines[0],
        ]
    )


def double_gyre(x, t, amplitude=0.1, swing=0.25, period=10.0, length=1.0):
    """From the stream function A L sin(πf) sin(πy/L), differentiated numerically in the complex plane."""

    def stream(x, y):
        s = swing * np.sin(2 * np.pi * t / period)
        f = s * (x / length) ** 2 + (1 - 2 * s) * x / length
        return amplitude * length * np.sin(np.pi * f) * np.sin(np.pi * y / length)

    h = 1e-30
    return np.stack([-stream(x[0], x[1] + 1j * h).imag / h, stream(x[0] + 1j * h, x[1]).imag / h, 0 * x[2]])


def taylor_green(x, t, speed=1.0, length=1.0, viscosity=0.0):
    k = 2 * np.pi / length
    u = np.sin(k * x[0]) * np.cos(k * x[1])
    v = -np.cos(k * x[0]) * np.sin(k * x[1])
    return speed * np.exp(-2 * viscosity * k**2 * t) * np.stack([u, v, 0 * u])


CASES = [
    ("abc", abc, {"amplitudes": (1.0, 0.8, 0.6), "wave_number": 1.7}),
    ("abc", abc, {"amplitudes": (0.9, 0.0, -1.3)}),
    ("double_gyre", double_gyre, {"amplitude": 0.1, "swing": 0.25, "period": 10.0}),
    ("double_gyre", double_gyre, {"amplitude": -0.4, "swing": 0.1, "period": 2.0, "length": 1.6}),
    ("taylor_green", taylor_green, {"speed": 1.3, "length": 2.5, "viscosity": 0.02}),
    ("taylor_green", taylor_green, {"speed": 0.7, "length": 0.9}),
    ("uniform", uniform, {"velocity": (0.7, -0.3, 1.9)}),
    ("uniform", uniform, {"velocity": (0, 0.9, 0)}),
    ("vortex", vortex, {"circulation": 2.3, "core": 0.4}),
    ("vortex", vortex, {"circulation": -1.7, "core": 0.9, "center": (0.3, -0.2, 0.6), "axis": (0.5, 2, -1)}),
    ("vortex", vortex, {"circulation": 0.8, "core": 0.05, "center": (0.3, 0, 0), "axis": (-1, 0, 0)}),
]


def worst(precision, kind, reference, parts, **otherwise):
    x, t = rounded(PLACES, precision), rounded(TIMES, precision)
    right = reference(x, t, **{**parts, **otherwise})
    found = velocity(precision, spec(type=kind, **parts), x, t)
    # Where terms cancel, rounding counts by their size: that of a wave, or locally that of a single vortex.
    size = np.linalg.norm(right, axis=0)
    return np.max(np.linalg.norm(found - right, axis=0) / (size.max() if kind in WAVES else size))


@pytest.mark.parametrize(("kind", "reference", "parts"), CASES)
def test_velocity_is_what_the_formula_says(precision, kind, reference, parts):
    assert worst(precision, kind, reference, parts) < 40 * EPSILON[precision]


@pytest.mark.parametrize(
    ("case", "key"),
    [(case, key) for case in CASES for key, value in case[2].items() if key != "axis"],
)
def test_a_formula_with_one_number_wrong_does_not_match(case, key):
    kind, reference, parts = case
    wrong = tuple(1.01 * value + 0.001 for value in parts[key]) if np.ndim(parts[key]) else 1.01 * parts[key]
    assert worst("double", kind, reference, parts, **{key: wrong}) > 1e-3


def test_a_vortex_turns_right_handed_about_its_axis():
    u = velocity("double", spec(type="vortex", circulation=1, axis=[0, 0, 1]), np.array([[1.0], [0], [0]]), [0.0])
    assert u[1, 0] > 0.1


def test_the_middle_of_a_vortex_is_a_rotation(precision):
    parts = {"circulation": 2.0, "core": 0.5, "axis": [0, 0, 1]}
    x = np.array([[0.0, 1e-6, 0.0, 1e-3], [0.0, 0.0, 1e-6, 0.0], [0.0, 5.0, -5.0, 0.0]])
    spin = 2.0 / (2 * np.pi * 0.25)
    found = velocity(precision, spec(type="vortex", **parts), x, np.zeros(4))
    np.testing.assert_allclose(found, spin * np.stack([-x[1], x[0], 0 * x[2]]), rtol=1e-5)


def test_expressions_of_place_and_time(precision):
    written = spec(type="expression", velocity=["x*y - t", "sin(z) + 0.5", "2.5"])
    x, t = rounded(PLACES, precision), rounded(TIMES, precision)
    right = np.stack([x[0] * x[1] - t, np.sin(x[2]) + 0.5, np.full_like(t, 2.5)])
    np.testing.assert_allclose(velocity(precision, written, x, t), right, atol=20 * EPSILON[precision])


@pytest.mark.parametrize(("kind", "reference", "parts"), [case for case in CASES if case[0] in WAVES])
def test_waves_have_no_divergence(kind, reference, parts):
    slopes = gradient("double", spec(type=kind, **parts), PLACES, TIMES)
    divergence = slopes[0, 0] + slopes[1, 1] + slopes[2, 2]
    assert np.abs(divergence).max() < 1e-14 * np.abs(slopes).max()
    assert np.abs(slopes[0, 0] + slopes[0, 1]).max() > 0.1 * np.abs(slopes).max()


EXAMPLES = {
    scene.UniformFlow: {"type": "uniform", "velocity": [0, 1, 0]},
    scene.VortexFlow: {"type": "vortex", "circulation": 1},
    scene.CurlNoiseFlow: {"type": "curl_noise", "length": 1, "speed": 1},
    scene.AbcFlow: {"type": "abc"},
    scene.DoubleGyreFlow: {"type": "double_gyre"},
    scene.TaylorGreenFlow: {"type": "taylor_green"},
    scene.ExpressionFlow: {"type": "expression", "velocity": ["y", "0", "0"]},
}


def test_every_flow_of_the_scene_language_has_its_term():
    kinds = typing.get_args(typing.get_args(scene.FlowTerm)[0])
    assert set(kinds) == set(EXAMPLES)
    terms = [type(flow_term(spec(**EXAMPLES[kind]))) for kind in kinds]
    assert len(set(terms)) == len(kinds)
    assert all(issubclass(term, FlowTerm) for term in terms)


def test_the_seed_of_the_scene_reaches_the_turbulence():
    noise = [spec(type="curl_noise", length=1, speed=1)]
    one, same, other = (flow_terms(noise, seed)[0].table for seed in (1, 1, 2))
    assert np.array_equal(one, same)
    assert not np.isclose(one[:, 4], other[:, 4]).any()

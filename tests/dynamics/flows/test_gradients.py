"""The gradient of every flow is the slope of its velocity."""

import numpy as np
import pytest

from tests.dynamics.flows.test_flow_references import CASES, spec
from tests.dynamics.harness import gradient, rounded, velocity

RANDOM = np.random.default_rng(32)
STEP = 1e-3
SPECS = [
    *(spec(type=kind, **parts) for kind, _, parts in CASES),
    spec(type="curl_noise", length=0.9, speed=0.6, lifetime=0.7),
    spec(type="expression", velocity=["x*y - t", "sin(z) + 0.5*x**2", "2.5"]),
]


@pytest.fixture(scope="module")
def places():
    return rounded(RANDOM.uniform(-2, 2, (3, 400)), "single"), rounded(RANDOM.uniform(0, 3, 400), "single")


@pytest.fixture(scope="module")
def found(places):
    return {
        (precision, number): gradient(precision, flow, *places)
        for precision in ("single", "double")
        for number, flow in enumerate(SPECS)
    }


@pytest.mark.parametrize("number", range(len(SPECS)), ids=lambda number: f"{SPECS[number].type} {number}")
def test_the_gradient_is_the_slope_of_the_velocity(found, places, number):
    x, t = places

    def at(way, steps):
        return velocity("double", SPECS[number], x + steps * STEP * way[:, None], t)

    right = np.stack(
        [(8 * (at(way, 1) - at(way, -1)) - (at(way, 2) - at(way, -2))) / (12 * STEP) for way in np.eye(3)],
        axis=1,
    )
    size = np.abs(right).max()
    # Differences across a vortex core thinner than the others' eddies are worth less.
    tolerance = 1e-3 if getattr(SPECS[number], "core", 1.0) < 0.1 else 1e-6
    np.testing.assert_allclose(found["double", number], right, atol=tolerance * size)
    np.testing.assert_allclose(found["single", number], found["double", number], atol=2e-5 * size)
    if size > 0:
        assert np.abs(found["double", number] - 0.98 * right).max() > 10 * tolerance * size


def test_the_middle_of_a_vortex_turns_rigidly():
    flow = spec(type="vortex", circulation=2.0, core=0.5, axis=[0, 0, 1])
    found = gradient("double", flow, np.array([[0.0], [0.0], [3.0]]), [0.0])[..., 0]
    spin = 2.0 / (2 * np.pi * 0.25)
    np.testing.assert_allclose(found, [[0, -spin, 0], [spin, 0, 0], [0, 0, 0]], atol=1e-15)

"""Every entry of every tableau and splitting, in NumPy: they have their orders, and one wrong entry takes them away."""

import numpy as np
import pytest

from particlecli.auto.steps import Motion, Sampled
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import ClosedForm
from tests.dynamics.stepping import stepped
from tests.dynamics.wrong_schemes import wrong_schemes

STEPPED = [name for name, scheme in SCHEMES.items() if not isinstance(scheme, ClosedForm)]
STEPS = {1: (64, 128), 2: (32, 64), 3: (16, 32), 4: (16, 32), 5: (12, 24), 8: (4, 8)}
"""For each order numbers of steps in a second whose errors tell it."""
COMPOSED = (5, 10)
FINER = 4
"""Times as many steps with which an order is lost that a wrong entry takes."""


def slopes(states, times, weights):
    """Three driven oscillators that act on each other."""
    x, y, z, u, v, w = states
    force = -4 * x + 0.3 * y * y + np.sin(3 * times), -3 * y - 0.5 * x * z, -2 * z + 0.2 * x + np.cos(2 * times)
    return np.stack([u, v, w, *force])


def jacobian(states, times, weights):
    x, y, z = states[:3]
    by_position = np.zeros((states.shape[1], 3, 3))
    by_position[:, 0, 0], by_position[:, 0, 1] = -4, 0.6 * y
    by_position[:, 1, 0], by_position[:, 1, 1], by_position[:, 1, 2] = -0.5 * z, -3, -0.5 * x
    by_position[:, 2, 0], by_position[:, 2, 2] = 0.2, -2
    return np.stack([by_position, np.zeros_like(by_position)])


MOTION = Motion(slopes, jacobian)


def flown(scheme, steps):
    """The state after a second."""
    h = np.full(1, 1.0 / steps)
    sample = Sampled(np.array([[1.0, 0.5, -0.3, 0.2, -0.6, 0.8]]).T, np.zeros(1), np.ones(1))
    for _ in range(steps):
        sample = Sampled(stepped(scheme, MOTION, sample, h), sample.times + h, sample.weights)
    return sample.states


@pytest.fixture(scope="module")
def right():
    return flown(SCHEMES["dop853"], 200)


def order(scheme, counts, right):
    errors = [np.abs(flown(scheme, count) - right).max() for count in counts]
    return np.log2(errors[0] / errors[1])


def counts_of(name, finer=1):
    counts = COMPOSED if name == "composition8" else STEPS[SCHEMES[name].order]
    return [finer * count for count in counts]


@pytest.mark.parametrize("name", STEPPED)
def test_each_scheme_has_its_order(name, right):
    assert order(SCHEMES[name], counts_of(name), right) == pytest.approx(SCHEMES[name].order, abs=0.3)


@pytest.mark.parametrize(("name", "wrong"), wrong_schemes())
def test_one_wrong_entry_takes_the_order(name, wrong, right):
    assert order(wrong, counts_of(name, FINER), right) < SCHEMES[name].order - 0.3


@pytest.mark.parametrize(
    ("name", "part", "embedded"),
    [("dormand_prince", "error", 4), ("dop853", "error", 5), ("dop853", "coarse_error", 3)],
)
def test_error_estimates_are_differences_of_methods_of_the_orders_they_have(name, part, embedded):
    scheme = SCHEMES[name]
    weights, c = np.array(getattr(scheme, part)), np.array(scheme.c)

    def moments(weights):
        return np.abs([weights @ c**power for power in range(embedded + 1)])

    assert (moments(weights)[:embedded] < 1e-13).all()
    assert moments(weights)[embedded] > 1e-5
    for entry in np.flatnonzero(weights):
        wrong = weights * np.where(np.arange(len(c)) == entry, 1.001, 1.0)
        assert (moments(wrong)[:embedded] > 1e-6).any()

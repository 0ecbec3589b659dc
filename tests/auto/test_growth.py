"""How errors of pilots go on growing: as time does, exponentially, or no longer."""

import math

import numpy as np
import pytest

from particlecli.auto.growth import LOST, growth, growth_rate

FRAMES = np.arange(1, 11)


@pytest.mark.parametrize("power", [0, 1, 2])
@pytest.mark.parametrize("flown", [5, 10])
def test_powers_of_time_are_no_chaos(power, flown):
    assert growth_rate(1e-4 * FRAMES[:flown] ** float(power)) == 0.0


@pytest.mark.parametrize("rate", [1.0, 2.0])
def test_the_rate_of_exponential_growth_is_found(rate):
    assert growth_rate(1e-6 * np.exp(rate * FRAMES[:5])) == pytest.approx(rate)


def test_growth_that_begins_late_counts():
    assert growth_rate(np.maximum(1e-4, 1e-6 * np.exp(1.5 * FRAMES))) == pytest.approx(1.5)


@pytest.mark.parametrize("sizes", [[1e-3, 1.0], [1.0, 0.0, 0.0, 0.0, 9.0], [1.0, 2.0, 9.0, 80.0, math.nan]])
def test_too_little_tells_nothing(sizes):
    assert growth_rate(np.array(sizes)) == 0.0


@pytest.mark.parametrize(("lost", "expected"), [(0.0, 4.0), (0.5, 4.0), (0.75, 1.0), (1.0, 1.0)])
def test_errors_go_on_growing_unless_nothing_is_known_by_then(lost, expected):
    assert growth(2, 8, lost=lost) == expected
    assert (lost > LOST) == (expected == 1.0)


def test_chaos_grows_exponentially_as_long_as_a_solution_can_be_followed():
    assert growth(5, 9, rate=0.5) == pytest.approx(math.exp(2.0))
    assert growth(5, 300, rate=0.5, bound=70.0) == 70.0
    assert growth(5, 300, rate=0.5, bound=0.2) == 1.0
    assert growth(5, 10**6, rate=1.0) > 1e300

"""Instants of birth: the rate's and the bursts' in one order, their number, and how many live at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from particlecli.dynamics.birth_times import AGE_ERROR, MOST_BIRTHS, WINDOWS, BirthTimes
from particlecli.errors import SceneError, SimulationError
from particlecli.scene.groups import Emitter


def births(duration: float = 4.0, **emitter: Any) -> BirthTimes:
    return BirthTimes("sparks", Emitter.model_validate(emitter), duration)


def instants(source: BirthTimes) -> NDArray[np.float64]:
    return source.of(np.arange(source.total))


@pytest.mark.parametrize("rate", [300, "300*(1 + sin(3*t))"])
def test_an_end_right_at_a_birth_includes_it_and_the_next_span_does_not_repeat_it(rate: float | str) -> None:
    source = births(rate=rate, start=0.1, bursts=[{"time": 1.5, "count": 30}, {"time": 0.25, "count": 7}])
    times = instants(source)
    for ends in (times, np.nextafter(times, -1), np.nextafter(times, 9)):
        assert (source.until(ends) == np.searchsorted(times, ends, side="right")).all()


def test_a_constant_rate_bears_one_in_the_middle_of_each_of_its_intervals() -> None:
    times = instants(births(rate=10, start=1, stop=2.5, duration=9.0))
    assert times == pytest.approx(1 + (np.arange(15) + 0.5) / 10, abs=1e-15)


def test_a_varying_rate_is_cut_at_start_and_stop() -> None:
    times = instants(births(rate="20*t", start=1, stop=2))
    assert times == pytest.approx(np.sqrt(1 + (np.arange(30) + 0.5) / 10), abs=1e-12)


def test_bursts_come_in_order_of_time_and_after_births_of_the_rate_at_the_same_instant() -> None:
    bursts = [{"time": 1, "count": 2}, {"time": 0.5, "count": 1}, {"time": 1, "count": 3}]
    source = births(rate=1, duration=2.0, bursts=bursts)
    assert instants(source).tolist() == [0.5, 0.5, 1, 1, 1, 1, 1, 1.5]
    assert source.until(np.array([-np.inf, 0.4, 0.5, 1, 2])).tolist() == [0, 0, 2, 7, 8]


def test_births_end_with_the_scene_births_at_its_very_end_included() -> None:
    bursts = [{"time": 2, "count": 5}, {"time": 2.001, "count": 100}]
    assert births(rate=1.25, bursts=bursts, duration=2.0).total == 3 + 5
    assert births(rate=100, start=3, duration=2.0).total == 0
    assert births(rate=100, stop=0, duration=2.0).total == 0
    assert births(rate="-3 - t", duration=2.0).total == 0


@pytest.mark.parametrize(
    ("emitter", "number"),
    [
        ({"rate": 1e9}, "4,000,000,000 particles"),
        ({"rate": "1e9*(1 + 0*t)"}, "4,000,000,000 particles"),
        ({"bursts": [{"time": 1, "count": 2 * 10**9}, {"time": 2, "count": 1}]}, "2,000,000,001 particles"),
        ({"rate": 1e308}, "inf particles"),
    ],
)
def test_absurdly_many_births_are_refused_by_number(emitter: dict[str, Any], number: str) -> None:
    with pytest.raises(SceneError, match=f"emitters.sparks  would give birth to {number}"):
        births(**emitter)


def test_very_many_births_cost_nothing_before_they_are_asked_for() -> None:
    source = births(rate=MOST_BIRTHS / 4 - 1)
    assert source.total == MOST_BIRTHS - 4
    assert source.largest_population(1.0, 0.0) == pytest.approx(MOST_BIRTHS / 4, rel=1e-4)
    assert source.of(source.until(np.array([3.0]))) == pytest.approx(3.0, abs=3e-9)


def test_a_rate_that_is_not_finite_names_its_group() -> None:
    with pytest.raises(SimulationError, match=r"emitter `sparks`: the rate `1/\(2 - t\)` is inf at t = 2 s"):
        births(rate="1/(2 - t)")


@settings(deadline=None, max_examples=50)
@given(
    rate=st.sampled_from(["0", "30", "40*(1 + sin(7*t))", "where(t < 1, 0, 90)"]),
    bursts=st.lists(st.tuples(st.floats(0, 4), st.integers(1, 50)), max_size=3),
    life=st.floats(0.01, 5),
    interval=st.floats(0, 0.5),
)
def test_the_largest_population_is_the_fullest_window(rate, bursts, life, interval) -> None:
    source = births(rate=rate, bursts=[{"time": time, "count": count} for time, count in bursts])
    times = instants(source)
    span = life * (1 + AGE_ERROR) + interval
    counts = np.searchsorted(times, times + span, side="right") - np.arange(len(times))
    assert source.largest_population(life, interval) == counts.max(initial=0)
    assert source.largest_population(None, interval) == len(times)


@pytest.mark.parametrize("start", [1.2, 1.20001, 1.20002, 1.20003])
def test_the_bound_for_many_births_is_never_too_small_and_hardly_too_large(start: float) -> None:
    bursts = [{"time": start, "count": 3}, {"time": start + 0.5, "count": 50_000}]
    source = births(rate=1e5, bursts=bursts)
    times = instants(source)
    exact = (np.searchsorted(times, times + 0.5 + 1e-12, side="right") - np.arange(len(times))).max()
    assert exact <= source.largest_population(0.5, 0.0) <= exact + source.total // WINDOWS + 2

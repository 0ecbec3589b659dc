"""The generator against its published vectors, and distributions against their cumulative functions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from particlecli.dynamics.random import CHUNK, Draw, Draws, philox4x32, sample
from particlecli.scene.distributions import Choice, LogNormal, Normal, Uniform

COUNT = 20_000
SURPRISING = 1e-3
"""Draws are fixed by the seed: a test passes or fails for ever."""


def draws(count: int = COUNT, seed: int = 7, name: str = "sparks") -> Draws:
    return Draws(seed, name, np.arange(count))


@pytest.mark.parametrize(
    ("counter", "key", "result"),
    [
        ("00000000 00000000 00000000 00000000", "00000000 00000000", "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
        ("ffffffff ffffffff ffffffff ffffffff", "ffffffff ffffffff", "408f276d 41c83b0e a20bc7c6 6d5451fd"),
        ("243f6a88 85a308d3 13198a2e 03707344", "a4093822 299f31d0", "d16cfe09 94fdcceb 5001e420 24126ea1"),
    ],
)
def test_philox_gives_the_known_answers_of_random123(counter: str, key: str, result: str) -> None:
    def words(text: str) -> list[int]:
        return [int(word, 16) for word in text.split()]

    counters = np.array(words(counter), np.uint64)[:, None].repeat(3, axis=1)
    low, high = words(key)
    assert (philox4x32(counters, (low, high)) == np.array(words(result))[:, None]).all()


def test_uniform_numbers_are_uniform_and_never_reach_the_ends() -> None:
    for draw in Draw:
        numbers = draws().uniform(draw)
        assert 0 < numbers.min() < numbers.max() < 1
        assert stats.kstest(numbers, "uniform").pvalue > SURPRISING


def test_the_extreme_words_stay_inside_the_open_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    for word, expected in ((0, 2.0**-53), (0xFFFFFFFF, 1 - 2.0**-53)):
        monkeypatch.setattr(
            "particlecli.dynamics.random.philox4x32",
            lambda counters, _, word=word: np.full_like(counters, word),
        )
        assert draws(1).uniform(0) == expected


def test_draws_groups_and_seeds_are_independent_of_each_other() -> None:
    columns = [draws().uniform(draw) for draw in Draw]
    columns += [draws(name="smoke").uniform(0), draws(seed=8).uniform(0)]
    correlations = np.corrcoef(columns) - np.eye(len(columns))
    assert np.abs(correlations).max() < 5 / np.sqrt(COUNT)


@settings(deadline=None)
@given(st.lists(st.integers(0, 2**40), min_size=1, max_size=50), st.sampled_from(Draw))
def test_a_number_depends_on_its_own_index_alone(indices: list[int], draw: Draw) -> None:
    together = Draws(3, "a", np.array(indices)).uniform(draw)
    alone = [Draws(3, "a", np.array([index])).uniform(draw)[0] for index in indices]
    assert together.tolist() == alone


def test_chunks_leave_no_seam_and_high_index_words_count() -> None:
    beyond = 2**32 + np.arange(2 * CHUNK + 5)
    numbers = Draws(0, "a", beyond).uniform(Draw.SPEED)
    assert len(np.unique(numbers)) == len(beyond)
    assert numbers[CHUNK] == Draws(0, "a", beyond[CHUNK : CHUNK + 1]).uniform(Draw.SPEED)[0]
    assert not np.isin(numbers, Draws(0, "a", beyond - 2**32).uniform(Draw.SPEED)).any()


def test_the_order_of_asking_for_quantities_does_not_matter() -> None:
    forwards, backwards = draws(), draws()
    one = {draw: forwards.uniform(draw) for draw in Draw}
    other = {draw: backwards.uniform(draw) for draw in reversed(Draw)}
    again = {draw: forwards.uniform(draw) for draw in Draw}
    for draw in Draw:
        assert (one[draw] == other[draw]).all()
        assert (one[draw] == again[draw]).all()


def test_the_first_numbers_are_what_they_have_always_been() -> None:
    numbers = Draws(7, "sparks", np.array([0, 1])).uniform(Draw.POSITION_1)
    assert numbers.tolist() == [0.6941518539149162, 0.43917947913795585]


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (Uniform(uniform=(-2, 3)), stats.uniform(-2, 5)),
        (Normal(normal=(10, 2)), stats.norm(10, 2)),
        (Normal(normal=(10, 2), min=9), stats.truncnorm(-0.5, np.inf, 10, 2)),
        (Normal(normal=(0, 1), min=-1, max=0.5), stats.truncnorm(-1, 0.5)),
        (Normal(normal=(0, 1), min=4.5), stats.truncnorm(4.5, np.inf)),
        (Normal(normal=(0, 1), max=-4.5), stats.truncnorm(-np.inf, -4.5)),
        (LogNormal(log_normal=(3, 0.4)), stats.lognorm(0.4, scale=3)),
    ],
)
def test_continuous_distributions(value: Uniform | Normal | LogNormal, expected: stats.rv_continuous) -> None:
    numbers = sample(value, draws(), Draw.SPEED)
    assert stats.kstest(numbers, expected.cdf).pvalue > SURPRISING
    lowest, highest = value.support
    assert numbers.min() >= lowest
    assert numbers.max() <= highest
    assert (np.argsort(numbers) == np.argsort(draws().uniform(Draw.SPEED))).all()


def test_the_far_tail_of_a_normal_keeps_its_resolution() -> None:
    numbers = sample(Normal(normal=(0, 1), min=5.9), draws(), Draw.SPEED)
    assert len(np.unique(numbers)) > 0.99 * COUNT


def test_a_normal_never_leaves_the_support_it_was_checked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    value = Normal(normal=(1500, 249))
    for uniform, end in ((2.0**-53, 0), (1 - 2.0**-53, 1)):
        monkeypatch.setattr(Draws, "uniform", lambda *_, uniform=uniform: np.array([uniform]))
        assert sample(value, draws(1), Draw.SPEED)[0] == pytest.approx(value.support[end], rel=1e-3)
        assert value.support[0] <= sample(value, draws(1), Draw.SPEED)[0] <= value.support[1]


def test_choice_follows_its_weights_and_never_takes_a_weight_of_zero() -> None:
    value = Choice(choice=(1, 2, 3, 4), weights=(0, 3, 1, 0))
    numbers = sample(value, draws(), Draw.MASS)
    values, counts = np.unique(numbers, return_counts=True)
    assert values.tolist() == [2, 3]
    assert stats.chisquare(counts, [0.75 * COUNT, 0.25 * COUNT]).pvalue > SURPRISING


def test_choice_without_weights_is_even() -> None:
    _, counts = np.unique(sample(Choice(choice=(5, 1, 3)), draws(), Draw.MASS), return_counts=True)
    assert stats.chisquare(counts).pvalue > SURPRISING


def test_rounding_never_chooses_beyond_the_last_value(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Draws, "uniform", lambda *_: np.array([1 - 2.0**-53]))
    for count in range(1, 60):
        value = Choice(choice=tuple(range(count)), weights=(0.1,) * count)
        assert sample(value, draws(1), Draw.MASS)[0] == count - 1


@pytest.mark.parametrize("value", [2.5, Uniform(uniform=(2.5, 2.5)), Normal(normal=(2.5, 0)), Choice(choice=(2.5,))])
def test_a_distribution_without_spread_is_its_number(value: float | Uniform | Normal | Choice) -> None:
    assert (sample(value, draws(100), Draw.MASS) == 2.5).all()


def test_rounding_never_leaves_a_narrow_interval() -> None:
    assert (sample(Uniform(uniform=(3.1252, 3.1252)), draws(), Draw.MASS) == 3.1252).all()

"""Integrals of rates and their inverses against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from particlecli.dynamics import rates
from particlecli.dynamics.rates import ConstantRate, VaryingRate
from particlecli.errors import SimulationError
from particlecli.scene.expression import Expression


def varying(source: str, start: float = 0.0, stop: float = 8.0) -> VaryingRate:
    return VaryingRate(Expression(source), start, stop)


def test_a_constant_rate_counts_from_start_to_stop_only() -> None:
    rate = ConstantRate(4.0, 1.0, 3.0)
    assert rate.total == 8.0
    assert rate.integral(np.array([-np.inf, 0, 1, 1.5, 3, 9])).tolist() == [0, 0, 0, 2, 8, 8]
    assert rate.instants(np.array([0.5, 4, 8])).tolist() == [1.125, 2, 3]


@pytest.mark.parametrize(
    ("source", "integral", "tolerance"),
    [
        ("100*(1 + sin(t))", lambda t: 100 * (t + 1 - np.cos(t)), 1e-11),
        ("100*exp(-t)", lambda t: 100 * (1 - np.exp(-t)), 1e-11),
        ("30*t**2", lambda t: 10 * t**3, 1e-11),
        ("100*sqrt(t)", lambda t: 200 / 3 * t**1.5, 1e-10),
        ("50*max(0, 2 - t)", lambda t: 25 * (4 - np.maximum(2 - t, 0) ** 2), 1e-11),
        ("50*(2 - t)", lambda t: 25 * (4 - np.maximum(2 - t, 0) ** 2), 1e-11),
        ("where(t < 1.2345, 1000, 10)", lambda t: 10 * t + 990 * np.minimum(t, 1.2345), 1e-9),
        (
            "1000*floor(t)",
            lambda t: 1000 * (np.floor(t) * (np.floor(t) - 1) / 2 + np.floor(t) * (t % 1)),
            1e-8,
        ),
    ],
)
def test_integrals_match_their_closed_form(source, integral, tolerance) -> None:
    times = np.linspace(0, 8, 1001)[:-1]
    rate = varying(source)
    assert np.abs(rate.integral(times) - integral(times)).max() < tolerance
    assert rate.total == pytest.approx(integral(np.float64(8 - 1e-15)), abs=tolerance, rel=1e-13)


def test_instants_invert_the_closed_form() -> None:
    rate = varying("100*(1 + sin(t))")
    targets = np.arange(int(rate.total)) + 0.5
    exact = [
        brentq(lambda t, target=target: 100 * (t + 1 - np.cos(t)) - target, 0, 8, xtol=1e-15) for target in targets
    ]
    assert np.abs(rate.instants(targets) - exact).max() < 1e-11


def test_nothing_is_born_while_the_rate_is_not_positive() -> None:
    rate = varying("1000*sin(pi*t)")
    instants = rate.instants(np.arange(int(rate.total)) + 0.5)
    assert rate.total == pytest.approx(4 * 2000 / np.pi, rel=1e-12)
    assert (instants % 2 <= 1).all()
    assert (np.diff(instants) > 0).all()


def test_a_narrow_peak_is_found() -> None:
    assert varying("where(abs(t - 3.3) < 0.001, 1e5, 0)").total == pytest.approx(200, rel=1e-9)


def test_a_rate_faster_than_any_cell_still_has_its_mean_and_its_order() -> None:
    rate = varying("2e8*max(0, sin(1e7*t))")
    assert rate.total == pytest.approx(16e8 / np.pi, rel=1e-3)
    assert (np.diff(rate.instants(np.arange(3e8, 3e8 + 1e5) + 0.5)) > 0).all()


@pytest.mark.parametrize("scale", [1e-6, 1.0, 3.156e7])
def test_any_scale_of_time_is_resolved(scale: float) -> None:
    rate = varying(f"{100 / scale!r}*(1 + sin(t/{scale!r}))", 0.0, 8 * scale)
    assert rate.total == pytest.approx(100 * (9 - np.cos(8)), rel=1e-12)


def test_a_later_stop_does_not_move_earlier_births() -> None:
    targets = np.arange(300) + 0.5
    early, late = (varying("100*(1 + sin(t))", 0.5, stop).instants(targets) for stop in (5.0, 5.75))
    assert (early == late).all()


def test_a_cell_is_inverted_for_any_shape_and_each_target_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rates, "CELLS", 1)
    monkeypatch.setattr(rates, "TOLERANCE", 1.0)
    rate = varying("20*t*(1 - t)**3", stop=1.0)  # one cell, and Newton's method alone leaps out of it
    ends = np.logspace(-12, -1, 200)
    targets = np.concatenate([ends, np.linspace(0.1, 0.9, 200), 1 - ends[::-1]])
    instants = rate.instants(targets)
    late = 1 - instants
    assert 1 - 5 * late**4 + 4 * late**5 == pytest.approx(targets, abs=1e-13)
    assert instants[:200] == pytest.approx(np.sqrt(ends / 10), rel=0.2)
    alone = np.concatenate([rate.instants(targets[k : k + 1]) for k in range(len(targets))])
    assert (instants == alone).all()


@pytest.mark.parametrize(
    ("source", "place"),
    [("1/(t - 1)", "inf at t = 1 s"), ("sqrt(3 - t)", "nan at t = 3"), ("log(t)", "-inf at t = 0 s")],
)
def test_a_rate_that_is_not_finite_is_refused_with_its_time(source: str, place: str) -> None:
    with pytest.raises(SimulationError, match=place):
        varying(source)

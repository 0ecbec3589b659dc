"""Cooling against its closed forms."""

import numpy as np
import pytest

from tests.dynamics.scenes import system


def temperatures(cooling, start=1500.0, dt=0.02, precision="double"):
    made = system(
        precision=precision,
        particles={"a": {"positions": [[0, 0, 0]], "temperature": start, "cooling": cooling}},
        integrator={"type": "euler", "dt": dt},
    )
    found = []
    for frame in range(1, 11):
        made.advance(frame / 10)
        found.append(made.groups["a"].state.read(("temperature",))[0, 0])
    return np.array(found)


TIMES = np.arange(1, 11) / 10


@pytest.mark.parametrize("dt", [0.1, 0.003])
def test_newtons_law_is_exact_at_any_step(dt):
    found = temperatures({"rate": 2.5, "ambient": 300}, dt=dt)
    np.testing.assert_allclose(found, 300 + 1200 * np.exp(-2.5 * TIMES), rtol=1e-12)


@pytest.mark.parametrize("dt", [0.1, 0.003])
def test_radiation_into_cold_space_follows_the_closed_form(dt):
    coefficient = 3e-9
    found = temperatures({"radiative": coefficient, "ambient": 0}, dt=dt)
    np.testing.assert_allclose(found, (1500.0**-3 + 3 * coefficient * TIMES) ** (-1 / 3), rtol=1e-6)


def test_both_laws_together_satisfy_their_sum():
    from scipy.integrate import solve_ivp

    rate, radiative, ambient = 1.5, 1e-9, 400.0
    truth = solve_ivp(
        lambda t, T: -rate * (T - ambient) - radiative * (T**4 - ambient**4),
        (0, 1),
        [1500.0],
        rtol=1e-11,
        t_eval=TIMES,
    ).y[0]
    np.testing.assert_allclose(
        temperatures({"rate": rate, "radiative": radiative, "ambient": ambient}), truth, rtol=1e-5
    )


def test_cold_particles_die_when_they_cross_the_threshold():
    made = system(
        particles={
            "a": {
                "positions": [[0, 0, 0], [1, 0, 0]],
                "temperatures": [1500, 3000],
                "cooling": {"rate": 1.0, "ambient": 0},
                "dies": {"colder_than": 1000},
            }
        }
    )
    alive = []
    for frame in range(1, 11):
        made.advance(frame / 10)
        alive.append(made.alive)
    crossing = np.log(1.5)
    assert alive == [2 if frame / 10 < crossing else 1 for frame in range(1, 11)]
    assert made.deaths["a"] == {"cold": 1}

"""Orders, floors and fronts are read off the curves they belong to."""

import pytest

from particlecli.accuracy.curves import Key, curves, floor_of, order, pareto
from particlecli.accuracy.runs import Run
from particlecli.accuracy.tracks import Deviation, Spread

EXTENT = 1.0


def run(steps, error, seconds=None, integrator="rk4", precision="double"):
    spread = Spread(error, error, error)
    found = Deviation(spread, spread, None, None, 0.0) if error is not None else None
    return Run(
        integrator,
        precision,
        steps,
        1 / steps,
        None,
        found,
        seconds=steps * 1e-3 if seconds is None else seconds,
        particle_steps=100 * steps,
    )


def curve(power, floor=0.0, noise=(1.0, 1.0)):
    """Errors that fall with a power from 0.5 on until they come to a floor."""
    return [run(2**n, 0.5 * 2.0 ** (-power * n) + floor * noise[n % 2]) for n in range(14)]


@pytest.mark.parametrize("power", [1, 2, 4])
def test_the_order_is_the_exponent_between_coarse_and_floor(power):
    floor = 1e-7
    runs = curve(power, floor, noise=(1.0, 2.5))
    assert order(runs, floor, EXTENT) == pytest.approx(power, abs=0.12)
    assert order(runs, 1e-20, EXTENT) != pytest.approx(power, abs=0.3) or power == 1


def test_too_few_runs_tell_no_order():
    assert order(curve(8, 1e-7), 1e-7, EXTENT) is None
    assert order(curve(4)[:3], 1e-16, EXTENT) is None


def test_a_floor_is_where_halving_the_step_no_longer_helps():
    assert floor_of(curve(4, 1e-7, noise=(1.0, 2.5)), EXTENT) == pytest.approx(1e-7, rel=0.01)
    assert floor_of(curve(1), EXTENT) is None
    assert floor_of([run(2**n, 0.9) for n in range(9)], EXTENT) is None


def test_curves_go_from_few_steps_to_many_and_leave_out_what_failed():
    runs = [run(4, 0.1), run(2, None), run(1, 0.5), run(1, 0.2, precision="single"), run(2, 0.1, integrator="euler")]
    found = curves(runs)
    assert [each.steps for each in found[Key("rk4", "double")]] == [1, 4]
    assert set(found) == {Key("rk4", "double"), Key("rk4", "single"), Key("euler", "double")}


def test_the_front_holds_what_nothing_beats_in_both():
    a, b, c = run(1, 0.5, 1.0), run(1, 0.1, 2.0), run(1, 0.01, 4.0)
    beaten = [run(1, 0.6, 1.5), run(1, 0.1, 2.5), run(1, None, 0.1)]
    assert pareto([c, *beaten, a, b]) == [a, b, c]

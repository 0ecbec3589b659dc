"""A thinned scene is the same scene with fewer births."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from particlecli.dynamics.plan import make_plan
from particlecli.dynamics.sampling import spread, thinned
from tests.dynamics import scenes


@given(total=st.integers(0, 10**9), most=st.integers(1, 300))
def test_spread_takes_numbers_below_the_total_once_and_in_order(total, most):
    chosen = spread(total, most)
    assert len(chosen) <= most
    assert len(chosen) >= 0.6 * min(total, most)
    assert (np.diff(chosen) > 0).all()
    assert len(chosen) == 0 or (chosen[0] >= 0 and chosen[-1] < total)


@pytest.mark.parametrize("row", [10, 16, 64, 100])
def test_spread_is_in_step_with_no_lattice(row):
    columns = np.bincount(spread(100 * row**2, 40 * row) % row, minlength=row)
    assert columns.min() >= 20
    assert columns.max() <= 80


def scene():
    return scenes.scene(
        particles={"grid": {"layout": {"type": "grid", "spacing": 0.1, "counts": [8, 8, 8]}, "velocity": [1, 0, 0]}},
        emitters={
            "sparks": {
                "rate": 3000,
                "speed": {"uniform": [1, 3]},
                "direction": {"spread": 40},
                "lifetime": {"uniform": [0.1, 0.5]},
                "mass": {"uniform": [1, 2]},
            }
        },
        forces=[{"type": "gravity"}, {"type": "drag", "coefficient": 0.5}],
        integrator={"type": "midpoint"},
    )


def frames(plan):
    from particlecli import runtime

    runtime.start("single", 2)
    from particlecli.dynamics.system import System

    system = System(plan)
    for _ in range(2):
        shown = []
        for index in range(6):
            system.advance(index / 10)
            shown.append(system.frame(index))
        yield shown
        system.restart()


def test_a_sampled_particle_goes_where_it_goes_among_all_and_goes_there_again_after_a_restart():
    plan = make_plan(scene())
    whole, _ = frames(plan)
    first, again = frames(thinned(plan, 100))
    for all_of_them, some, repeated in zip(whole, first, again, strict=True):
        for name, group in some.groups.items():
            full = all_of_them.groups[name]
            places = np.searchsorted(full.ids, group.ids)
            chosen = spread(plan_of(plan, name).births.total, 100)
            np.testing.assert_array_equal(group.ids, np.intersect1d(full.ids, chosen))
            np.testing.assert_array_equal(group.positions, full.positions[places])
            np.testing.assert_array_equal(repeated.groups[name].positions, group.positions)
            np.testing.assert_array_equal(repeated.groups[name].ids, group.ids)


def plan_of(plan, name):
    return next(group for group in plan.groups if group.name == name)


def test_small_groups_stay_whole():
    plan = make_plan(scene())
    for group, same in zip(plan.groups, thinned(plan, 10_000).groups, strict=True):
        assert same.components == group.components
        np.testing.assert_array_equal(same.births.ids, np.arange(group.births.total))


def test_particles_that_act_on_each_other_stay_together():
    from particlecli.dynamics.plan import make_plan
    from particlecli.dynamics.sampling import thinned
    from tests.dynamics.scenes import scene

    stars = {"layout": {"type": "ball", "radius": 1, "count": 100}}
    plan = make_plan(scene(particles={"stars": stars, "dust": stars}, forces=[{"type": "attraction", "on": ["stars"]}]))
    assert [group.births.total for group in thinned(plan, 10).groups] == [100, 10]

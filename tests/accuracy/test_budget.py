"""What estimates may cost: counted, the same every time, never less for more. Nothing is compiled here."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from particlecli.accuracy import prices
from particlecli.accuracy.bound import Together
from particlecli.accuracy.prices import Besides, besides
from particlecli.accuracy.samples import COARSER, FINER, Carrier, Comparison
from particlecli.dynamics.integrators.base import ImplicitRungeKutta
from particlecli.dynamics.plan import Plan, make_plan
from particlecli.dynamics.system import System
from particlecli.scene.load import load_scene
from particlecli.scene.model import Scene
from tests.dynamics.scenes import scene

SCENES = Path(__file__).parents[2] / "scenes"
HD = (1280, 720)


def at_its_end(plan: Plan) -> System:
    """A system of a plan that has gone to its end in equal steps, as far as prices look at it."""
    steps = plan.steps_per_frame * (plan.scene.frame_count - 1)
    evaluations = {
        group.name: steps * group.capacity * (5 if isinstance(group.scheme, ImplicitRungeKutta) else 1)
        * group.scheme.evaluations
        for group in plan.groups
    }  # fmt: skip
    groups = {group.name: SimpleNamespace(plan=group) for group in plan.groups}
    time = (plan.scene.frame_count - 1) / plan.scene.fps
    return cast(System, SimpleNamespace(plan=plan, group_evaluations=evaluations, groups=groups, time=time))


def granted(described: Scene, made: Besides) -> Comparison | None:
    """The comparison that a run of a scene pays for, of its particles that act on each other."""
    system = at_its_end(make_plan(described))
    together = Together(system, [group.name for group in system.plan.groups if group.coupled])
    together.grant(prices.SHARE * (made.fixed + prices.simulated(system)))
    return together.comparison


def pictures(described: Scene, size: tuple[int, int] = HD) -> Besides:
    return besides(described, size, 0)


def test_a_snake_is_carried_again_with_a_video_and_not_without():
    snake = load_scene(SCENES / "snake.yaml")
    assert granted(snake, pictures(snake)) in (FINER, COARSER)
    assert granted(snake, besides(snake, None, 0)) is None
    assert granted(snake, Besides()) == FINER


@pytest.mark.parametrize("name", ["pleiades", "figure_eight"])
def test_three_and_seven_bodies_are_at_any_rate(name):
    described = load_scene(SCENES / "reference" / f"{name}.yaml", ["integrator={type: rk4, dt: 0.01}"])
    assert granted(described, besides(described, None, 0)) == FINER


@pytest.mark.parametrize("name", ["galaxies", "flag", "jelly", "hair", "gas", "reference/catenary"])
def test_what_takes_longer_to_simulate_than_to_draw_is_not(name):
    described = load_scene(SCENES / f"{name}.yaml")
    assert granted(described, pictures(described)) is None


CLOUD = {"layout": {"type": "ball", "radius": 1, "count": 4000}}


def test_many_that_attract_each_other_do_not_slip_through_in_few_steps():
    described = scene(
        duration=1,
        fps=10,
        particles={"stars": CLOUD},
        forces=[{"type": "attraction", "strength": 1, "softening": 0.1}],
        integrator={"type": "symplectic_euler", "dt": 0.1},
    )
    plan = make_plan(described)
    assert sum(at_its_end(plan).group_evaluations.values()) < 1e5
    assert granted(described, pictures(described)) is None


FORCES = {
    "attraction": {"type": "attraction", "strength": 1},
    "neighbours": {"type": "lennard_jones", "energy": 1, "size": 0.1},
    "springs": {"type": "springs", "stiffness": 10},
}
LINE = {"layout": {"type": "line", "start": [0, 0, 0], "end": [1, 0, 0], "count": 64}}


def price(force: str, scheme: str = "rk4", precision: str = "double", **group: object) -> float:
    plan = make_plan(
        scene(
            precision=precision,
            particles={"some": {**LINE, **group}},
            forces=[FORCES[force]],
            integrator={"type": scheme, "dt": 0.01},
        )
    )
    return prices.together(plan)


def test_prices_tell_dear_forces_and_schemes_from_cheap_ones():
    assert price("springs") < price("neighbours")
    assert price("springs") < price("attraction")
    assert price("springs") * 50 < price("springs", "implicit_euler")
    assert price("attraction", precision="single") < price("attraction")
    longer = {"layout": {**LINE["layout"], "count": 640}}
    assert price("attraction", **longer) > 50 * price("attraction")
    assert price("springs", **longer) < 20 * price("springs")


def test_more_to_draw_pays_for_more():
    snake = load_scene(SCENES / "snake.yaml")
    sizes = [None, (64, 36), (640, 360), HD, (3840, 2160)]
    fixed = [besides(snake, size, 0).fixed for size in sizes]
    assert fixed == sorted(set(fixed))
    ranks = [_rank(granted(snake, besides(snake, size, 0))) for size in sizes]
    assert ranks == sorted(ranks)
    assert ranks[0] < ranks[-1]
    light = snake.model_copy(update={"look": snake.look.model_copy(update={"groups": {}})})
    assert pictures(light).fixed < pictures(snake).fixed
    assert besides(snake, None, 2).point == 2 * besides(snake, None, 1).point > besides(snake, None, 0).point == 0.0


def _rank(comparison: Comparison | None) -> int:
    return [None, COARSER, FINER].index(comparison)


class Two(Carrier):
    """Particles that can be compared in two ways."""

    def comparisons(self):
        return [FINER, COARSER]

    def price(self, comparison):
        return {FINER: 6.0, COARSER: 0.75}[comparison]


def test_the_best_that_can_be_paid_for_is_chosen():
    carriers = [Two() for _ in range(5)]
    paid = [carrier.grant(price) for carrier, price in zip(carriers, (-1.0, 0.7, 0.75, 5.9, 6.0), strict=True)]
    assert [carrier.comparison for carrier in carriers] == [None, None, COARSER, COARSER, FINER]
    assert paid == [0.0, 0.0, 0.75, 0.75, 6.0]
    assert all(first <= second for first, second in pairwise(paid))

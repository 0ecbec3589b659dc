"""What `auto` chooses: cheap enough, accurate enough, always the same, and told."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import ValidationError

from particlecli.accuracy.estimate import ErrorEstimate
from particlecli.accuracy.tracks import deviation
from particlecli.accuracy.trial import Pace, Trial, trial_plan
from particlecli.auto.outcome import Choice, Tried
from particlecli.auto.resolve import resolved
from particlecli.auto.safe import SafeSteps
from particlecli.auto.terms import FORETOLD, STEADY, TOGETHER, UNSEEN
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.plan import make_plan
from particlecli.dynamics.sampling import chosen
from particlecli.render.camera import View
from particlecli.runtime import start
from particlecli.scene.integrator import ADAPTIVE, Integrator
from particlecli.scene.load import load_scene
from particlecli.simulate import Simulation
from tests.dynamics.scenes import body, scene

ROOT = Path(__file__).parents[2] / "scenes"


def auto(tolerance=None, **more):
    return {"type": "auto", **({} if tolerance is None else {"tolerance": tolerance}), **more}


FALLING = {
    "duration": 2,
    "fps": 20,
    "emitters": {
        "balls": {
            "rate": 60,
            "speed": {"uniform": [2, 6]},
            "direction": {"spread": 40},
            "mass": {"uniform": [0.5, 2]},
            "lifetime": {"uniform": [0.5, 1.5]},
        }
    },
    "forces": [{"type": "gravity"}, {"type": "quadratic_drag", "coefficient": 0.2}],
    "planes": [{"normal": [0, 1, 0], "restitution": 0.5, "friction": 0.3}],
    "camera": {"position": [0, 1, 8], "look_at": [0, 1, 0]},
}


def true_error(described, integrator, particles=600):
    """At the worst frame, of 95 in 100 particles of the group furthest off: metres, and pixels if any are seen."""
    view = View.of(described.camera, *described.camera.resolution)
    ids = {group.name: chosen(group.births, particles) for group in make_plan(described).groups}
    start("double", 1)
    best = Trial(trial_plan(described, "dop853", "double", particles), ids, measures_energy=False)
    reference = best.run(Pace(tolerance=1e-12)).tracks
    start(described.precision, 1)
    trial = Trial(trial_plan(described, integrator.type, described.precision, particles), ids, measures_energy=False)
    steps = None if integrator.dt is None else round(1 / described.fps / integrator.dt)
    run = trial.run(Pace(steps=steps, tolerance=integrator.tolerance))
    return deviation(run.tracks, reference, view)


@pytest.mark.parametrize(
    "tolerance", [pytest.param("20 px", marks=pytest.mark.slow), "0.5 px", pytest.param(1e-4, marks=pytest.mark.slow)]
)
def test_what_is_chosen_is_as_accurate_as_asked_for(tolerance):
    described = scene(**FALLING, integrator=auto(tolerance))
    changed, choice = resolved(described, 1)
    assert choice is not None
    error = true_error(described, changed.integrator)
    goal = choice.goal
    assert (error.worst.p95 if goal.unit == "m" else error.worst_pixels.p95) <= goal.size
    assert choice.chosen.error <= goal.size
    assert all(each.why for each in choice.rejected)


def test_the_smaller_the_error_the_dearer_the_choice():
    costs = [resolved(scene(**FALLING, integrator=auto(size)), 1)[1].chosen.cost for size in (0.1, 1e-3, 1e-5)]
    assert costs == sorted(costs)
    assert costs[0] < costs[-1]


def test_the_same_scene_gets_the_same_choice_on_any_number_of_threads():
    first, second = (resolved(scene(**FALLING, integrator=auto()), threads)[1] for threads in (1, 2))
    assert first == second


def test_a_closed_form_is_taken_where_nothing_else_is_that_good():
    stiff = scene(
        particles={"pellets": body((0, 1, 0), (1, 0, 0), mass=1e-3)},
        forces=[{"type": "gravity"}, {"type": "drag", "coefficient": 30}],
        integrator=auto(1e-9),
        precision="double",
    )
    assert resolved(stiff, 1)[1].chosen.scheme == "exact"


@pytest.mark.slow
def test_wide_ellipses_get_steps_of_their_own():
    comet = load_scene(ROOT / "reference/kepler.yaml", ["integrator={type: auto, tolerance: 1e-7}"])
    changed, choice = resolved(comet, 1)
    assert choice.chosen.scheme in ADAPTIVE
    assert true_error(comet, changed.integrator).worst.p95 < 1e-7


def test_nothing_moves_nothing_is_flown():
    changed, choice = resolved(scene(particles={"a": body((0, 0, 0), (1, 0, 0))}, integrator=auto()), 1)
    assert choice.chosen.error == 0.0
    assert changed.integrator.dt == pytest.approx(0.1)


PAIR = {"pair": {"positions": [[0, 0, 0], [1, 0, 0]], "velocities": [[0, -0.7, 0], [0, 0.7, 0]], "masses": [1, 1]}}


@pytest.mark.slow
def test_particles_that_act_on_each_other_are_flown_as_a_whole():
    orbits = {
        "particles": PAIR,
        "forces": [{"type": "attraction", "strength": 1}],
        "duration": 3,
        "precision": "double",
    }
    described = scene(**orbits, integrator=auto(1e-4))
    changed, choice = resolved(described, 1)
    assert choice.holds
    assert {each.scheme for each in choice.rejected} | {choice.chosen.scheme} == set(TOGETHER.candidates)
    assert true_error(described, changed.integrator).worst.p95 <= 1e-4


def test_too_many_to_be_flown_get_an_adaptive_scheme():
    crowd = {"crowd": {"layout": {"type": "ball", "count": 3000, "radius": 1}}}
    described = scene(particles=crowd, forces=[{"type": "attraction", "strength": 1}], integrator=auto(1e-3))
    changed, choice = resolved(described, 1)
    assert changed.integrator.type == "dormand_prince"
    assert choice.rejected == ()
    assert not choice.holds


GRAINS = {
    "particles": {"grains": {"layout": {"type": "ball", "count": 2000, "radius": 1}, "mass": 0.01}},
    "forces": [{"type": "soft_sphere", "diameter": 0.01, "stiffness": 300, "damping": 0.1, "friction": 0.2}],
}
BODY = {
    "particles": {"body": {"layout": {"type": "grid", "counts": [12, 12, 12], "spacing": 0.1}, "mass": 0.01}},
    "forces": [{"type": "springs", "stiffness": 100}],
    "planes": [{"point": [0, -1, 0], "normal": [0, 1, 0]}],
}


@pytest.mark.parametrize("parts", [pytest.param(GRAINS, id="grains"), pytest.param(BODY, id="a body that lands")])
def test_contacts_of_too_many_to_be_flown_get_equal_steps(parts, monkeypatch):
    """Adaptive ones become ever shorter where contacts are remembered, and see nothing of landing."""
    monkeypatch.setattr("particlecli.auto.resolve.worth_flying", lambda _: False)
    described = scene(**parts, integrator=auto(1e-3))
    changed, choice = resolved(described, 1)
    assert changed.integrator.type == STEADY
    safe = SafeSteps(make_plan(described)).longest(SCHEMES[STEADY])
    assert safe / (UNSEEN + 1) < changed.integrator.dt <= safe / UNSEEN
    assert not choice.holds


@pytest.mark.parametrize(("foretold", "taken"), [(1, UNSEEN), (UNSEEN + 2, UNSEEN + 2), (3 * FORETOLD, FORETOLD)])
def test_contacts_get_the_steps_that_pilots_foretell_within_bounds(foretold, taken, monkeypatch):
    described = scene(**BODY, integrator=auto(1e-3))
    fewest = SafeSteps(make_plan(described)).fewest(SCHEMES[STEADY], described)
    wrong = Tried(STEADY, foretold * fewest, None, 1.0, 1.0, "would need more")
    best = Tried("rk4", 9, None, 0.5, 1.0, "")
    monkeypatch.setattr("particlecli.auto.resolve.choose", lambda *_: Choice(described.integrator.goal, best, (wrong,)))
    _, choice = resolved(described, 1)
    assert (choice.chosen.scheme, choice.chosen.steps) == (STEADY, taken * fewest)
    assert [each.scheme for each in choice.rejected] == ["rk4"]
    assert not choice.holds


@pytest.mark.slow
def test_children_count_as_much_as_their_parents():
    """Shells that fly in vacuum burst into stars that air stops, which no scheme follows in steps as long."""
    shells = {
        "emitters": {
            "shells": {
                "rate": 10,
                "speed": 8,
                "lifetime": 0.5,
                "children": {"on": "death", "emitter": "stars", "count": 9},
            },
            "stars": {"speed": 20, "direction": {"spread": 180}, "mass": 0.01},
        },
        "forces": [{"type": "gravity"}, {"type": "quadratic_drag", "coefficient": 0.01, "on": ["stars"]}],
        "integrator": auto(1e-3),
    }
    changed, choice = resolved(scene(**shells), 1)
    assert choice.holds
    simulation = Simulation(scene(**shells), threads=1)
    estimate = ErrorEstimate(simulation, lambda _: View.of(simulation.scene.camera, 640, 360))
    for frame in simulation:
        estimate.watch(frame)
    assert estimate.result()["stars"].metres.p95 <= 1e-3
    alone = {**shells["emitters"]["shells"], "children": []}
    without, _ = resolved(scene(**{**shells, "emitters": {"shells": alone}, "forces": [{"type": "gravity"}]}), 1)
    assert without.integrator != changed.integrator


def test_planes_that_move_are_beyond_pilots_and_get_a_short_step():
    lift = {"frames": {"lift": {"translate": [0, "0.2*sin(5*t)", 0]}}, "planes": [{"frame": "lift"}]}
    changed, choice = resolved(scene(**{**FALLING, **lift}, integrator=auto()), 1)
    assert (changed.integrator.type, changed.integrator.dt) == ("rk4", pytest.approx(0.005))
    assert choice.chosen.error is None
    assert "planes move" in choice.lines()[-1]


def test_a_simulation_takes_the_choice_and_tells_it():
    simulation = Simulation(scene(**FALLING, integrator=auto(dt=0.02)), threads=1)
    assert simulation.choice is not None
    assert simulation.scene.integrator.type == simulation.choice.chosen.scheme
    assert simulation.plan.step <= 0.02
    assert simulation.choice.lines()[0].startswith("auto chose ")
    assert simulation.choice.lines()[0].endswith("0.5 px are allowed")


def test_a_scene_with_a_scheme_stays_as_it_is():
    described = scene(**FALLING, integrator={"type": "rk4"})
    assert resolved(described) == (described, None)


@pytest.mark.parametrize(
    ("parts", "says"),
    [
        ({"type": "auto", "tolerance": "0.5 pt"}, "must be a positive number, of metres, or of pixels"),
        ({"type": "auto", "tolerance": "-1 px"}, "must be a positive number"),
        ({"type": "auto", "tolerance": 0}, "greater than 0"),
        ({"type": "dop853", "tolerance": "0.5 px"}, "a tolerance in pixels is for auto"),
        ({"type": "rk4", "tolerance": 1e-3}, "is for auto and for adaptive schemes"),
    ],
)
def test_tolerances_that_mean_nothing_are_refused(parts, says):
    with pytest.raises(ValidationError, match=says):
        Integrator.model_validate(parts)

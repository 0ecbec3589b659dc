"""The independent judge: against closed forms, through births and contacts, and what it refuses."""

import pytest

from particlecli.accuracy import judge as module
from particlecli.accuracy.bodies import CannotJudgeError
from particlecli.accuracy.judge import judge
from tests.cases import later
from tests.dynamics.scenes import body, scene

G = 10.0
DOWN = {"type": "gravity", "acceleration": [0, -G, 0]}
FINE = {"type": "rk4", "dt": 0.002}


def judged(**parts):
    return judge(scene(**{"precision": "double", **parts}))


def test_the_error_it_finds_is_the_true_one():
    """Explicit Euler falls short by ½ g dt t."""
    (found,) = judged(
        particles={"a": body((0, 1, 0), (1, 0, 0))}, forces=[DOWN], integrator={"type": "euler", "dt": 0.01}
    )
    assert found.final.metres == pytest.approx(0.5 * G * 0.01, rel=1e-9)
    assert found.largest.time == found.final.time == 1.0
    assert found.compared == 11


def test_it_tells_after_each_frame_how_far_it_is():
    told = []
    falling = scene(particles={"a": body((0, 1, 0), (1, 0, 0))}, forces=[DOWN], integrator=FINE)
    judge(falling, show=lambda done, alive: told.append((done, alive)))
    assert told == [(frame, 1) for frame in range(1, 12)]


def test_pixels_are_those_of_the_scenes_camera():
    camera = {"position": [0, 0, 10], "look_at": [0, 0, 0], "field_of_view": 90, "resolution": [800, 600]}
    parts = {
        "particles": {"a": body((0, 0, 0), (0, 0, 0))},
        "forces": [DOWN],
        "integrator": {"type": "euler", "dt": 0.01},
    }
    (seen,) = judged(**parts, camera=camera)
    assert seen.final.pixels == pytest.approx(0.05 * 300 / 10, rel=1e-6)
    (unseen,) = judged(**parts, camera={**camera, "look_at": [0, 0, 20]})
    assert unseen.final.pixels is None
    assert unseen.final.metres == seen.final.metres


@pytest.mark.slow
def test_newborn_are_followed_from_their_birth_in_a_flow_that_changes():
    """A uniform flow (0, t, 0) lifts what is born at b by (t² − b²)/2: Euler's step from b errs by ½ h each step."""
    parts = {
        "flows": {"up": [{"type": "expression", "velocity": [0, "t", 0]}]},
        "emitters": {"e": {"motion": "first_order", "flow": "up", "rate": 25, "lifetime": 0.4}},
    }
    (right,) = judged(**parts, integrator=FINE)
    assert right.largest.metres < 1e-12
    assert right.compared > 50
    (wrong,) = judged(**parts, integrator={"type": "euler", "dt": 0.1})
    assert 0.01 < wrong.largest.metres < 0.03


CONTACTS = {
    "bounces and rests": ([body((0, 1, 0), (0.7, 0, 0.2))], {"restitution": 0.5, "friction": 0.2}),
    "slides and stops": ([body((0, 0, 0), (2, 0, 1))], {"restitution": 0, "friction": 0.4}),
    "viscous": ([body((0, 0, 0), (2, 0, 1))], {"restitution": 0, "friction": {"viscous": 0.3}}),
    "slope": ([body((0, 0, 0), (0, 0, 0.3))], {"normal": [1, 2, 0], "restitution": 0, "friction": 0.2}),
    "sticks": ([body((0, 0.4, 0), (1, 0, 0))], {"on_hit": "stick"}),
}


@pytest.mark.parametrize("case", ["bounces and rests", "slope", *later("slides and stops", "viscous", "sticks")])
def test_contacts_agree_with_the_engine_which_was_written_apart(case):
    (group,), plane = CONTACTS[case]
    (found,) = judged(particles={"a": group}, forces=[DOWN], planes=[plane], integrator=FINE)
    assert found.largest.metres < 1e-9
    assert found.outlived == 0


@pytest.mark.slow
def test_leaving_a_plane_and_slipping_on_it():
    """A wind that grows with t² lifts one particle off at t² = ½, and moves the other, held by friction, then."""
    (lifted, pushed) = judged(
        particles={"lifted": body((0, 0, 0), (0.2, 0, 0)), "pushed": body((0, 0, 0), (0, 0, 0))},
        forces=[
            DOWN,
            {"type": "force_field", "force": [0, "20*t**2", 0], "on": ["lifted"]},
            {"type": "force_field", "force": ["10*t**2", 0, 0], "on": ["pushed"]},
        ],
        planes=[
            {"restitution": 0, "friction": 0, "on": ["lifted"]},
            {"restitution": 0, "friction": 0.5, "on": ["pushed"]},
        ],
        integrator=FINE,
    )
    assert lifted.largest.metres < 1e-6
    assert pushed.largest.metres < 1e-6


def test_a_flow_lays_tracers_on_a_plane_and_lifts_them_off():
    (found,) = judged(
        flows={"f": [{"type": "expression", "velocity": [1, "-cos(4*t)", 0]}]},
        particles={"a": {"motion": "first_order", "flow": "f", "positions": [[0, 0.1, 0], [0, 5, 0]]}},
        planes=[{"normal": [0.1, 1, 0]}],
        integrator=FINE,
    )
    assert found.largest.metres < 2e-3


def test_contacts_with_a_wrong_law_do_not_agree(monkeypatch):
    (group,), plane = CONTACTS["slides and stops"]
    weaker = {**plane, "friction": 0.2}
    made = scene(precision="double", particles={"a": group}, forces=[DOWN], planes=[plane], integrator=FINE)
    wrong = scene(precision="double", particles={"a": group}, forces=[DOWN], planes=[weaker])
    original = module.make_plan
    monkeypatch.setattr(module, "make_plan", lambda _: original(wrong))
    assert judge(made)[0].largest.metres > 0.01


@pytest.mark.slow
def test_what_a_plane_has_killed_must_not_live_on():
    """It dips below the plane and out again between two steps, at whose ends alone the simple scheme looks."""
    parts = {
        "particles": {"a": body((0, 0.02, 0), (0, -1, 0))},
        "forces": [{"type": "gravity", "acceleration": [0, 20, 0]}],
        "planes": [{"on_hit": "die"}],
    }
    (simple,) = judged(**parts, integrator={"type": "rk4", "dt": 0.1, "contact": "end_of_step"})
    assert simple.outlived == 1
    (located,) = judged(**parts, integrator=FINE)
    assert located.outlived == 0


def test_single_precision_is_judged_by_double():
    (found,) = judge(scene(particles={"a": body((0, 1, 0), (1, 0, 0))}, forces=[DOWN], integrator=FINE))
    assert 1e-9 < found.largest.metres < 1e-4


COUPLED = {"particles": {"a": {"positions": [[1, 0, 0], [2, 0, 0]]}}, "forces": [DOWN], "integrator": FINE}


def test_coupled_particles_are_followed_together(monkeypatch):
    monkeypatch.setattr(module, "ON_EACH_ALONE", ())
    (found,) = judged(**COUPLED)
    assert found.largest.metres < 1e-11


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ({**COUPLED, "planes": [{}]}, "couples particles"),
        ({**COUPLED, "emitters": {"e": {"rate": 5}}}, "couples particles"),
    ],
)
def test_coupled_particles_that_come_or_collide_are_refused(monkeypatch, parts, reason):
    monkeypatch.setattr(module, "ON_EACH_ALONE", ())
    with pytest.raises(CannotJudgeError, match=reason):
        judged(**parts)


def test_too_many_are_refused_before_anything_runs():
    crowd = {"layout": {"type": "ball", "radius": 1, "count": 10**6}}
    with pytest.raises(CannotJudgeError, match="too many for SciPy"):
        judged(particles={"a": crowd})


def test_rest_on_two_planes_is_refused():
    planes = [
        {"normal": [1, 1, 0], "restitution": 0, "friction": 0.1},
        {"normal": [-1, 1, 0], "restitution": 0, "friction": 0.1},
    ]
    with pytest.raises(CannotJudgeError, match="two planes"):
        judged(particles={"a": body((0.3, 0.5, 0), (0, 0, 0))}, forces=[DOWN], planes=planes, integrator=FINE)


def test_a_particle_that_leaves_a_plane_from_below_is_refused():
    with pytest.raises(CannotJudgeError, match="below a plane"):
        judged(particles={"a": body((0, -1, 0), (0, 1, 0))}, planes=[{}], integrator=FINE)


def test_the_larger_of_two_deviations_keeps_metres_and_pixels_apart():
    near = module.Deviation(metres=2.0, pixels=None, particle=1, time=0.5)
    far = module.Deviation(metres=1.0, pixels=7.0, particle=2, time=0.7)
    assert near.or_larger(far) == module.Deviation(2.0, 7.0, 1, 0.5)
    assert far.or_larger(None) is far

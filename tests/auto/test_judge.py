"""How pilots are judged: in the part of their flights where they are furthest off, and from steps of what kind."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from particlecli.auto.choice import choose
from particlecli.auto.judge import FINE, HALVINGS, Judge
from particlecli.auto.pilot import Flight
from particlecli.auto.safe import SafeSteps
from particlecli.auto.terms import STEADY, TOGETHER, UNSEEN, lands, remembers
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.plan import make_plan
from particlecli.scene.integrator import ADAPTIVE
from tests.dynamics.scenes import body, scene

COUNT, FLOWN = 40, 8
OFF = 1e-3


@dataclass
class Flier:
    """Stands for a pilot of particles that rest; with few steps a third of them is off in the last frame.

    Attributes:
        total: frames of the scene.
        flown: those that it flies.
        lands: whether bodies of springs meet planes at the ends of steps.
        asked: by scheme, with how many steps it flew.
    """

    total: int
    flown: int = FLOWN
    moves: bool = True
    lands: bool = False
    asked: list = field(default_factory=list)

    def __post_init__(self):
        self.frames, self.first_frames = np.full(COUNT, self.total), np.zeros(COUNT)

    @property
    def sees_all(self):
        return self.flown == self.total

    def fly(self, scheme, *, steps=1, tolerance=None):
        self.asked.append((scheme, steps))
        positions = np.zeros((self.flown, COUNT, 3))
        if tolerance is None:
            positions[-1, : COUNT // 3, 0] = OFF / steps
        return Flight(positions, 4.0 if tolerance else float(steps))


def resting(duration, **more):
    pair = {"pair": {**body((0, 0, 0), (1, 0, 0)), "mass": 0.01}}
    goal = {"type": "auto", "tolerance": 1e-3}
    return scene(
        **{"particles": pair, "integrator": goal, "precision": "double", "fps": 10, "duration": duration, **more}
    )


@pytest.mark.parametrize("total", [FLOWN, 20 * FLOWN])
def test_errors_at_the_end_of_what_was_flown_count_in_a_scene_of_any_length(total):
    pilot = Flier(total)
    judge = Judge(resting(total / 10), [pilot], TOGETHER)
    growth = total / FLOWN
    assert judge.error([pilot.fly(SCHEMES["rk4"], steps=2)]) == pytest.approx(growth * OFF / 2)


def test_frames_at_which_most_particles_are_lost_do_not_count():
    """There the references agree of some particles by chance."""

    class Chaotic(Flier):
        def fly(self, scheme, *, steps=1, tolerance=None):
            flight = super().fly(scheme, steps=steps, tolerance=tolerance)
            flight.positions[:, :, 0] = 0.0
            flight.positions[FLOWN // 2 :, COUNT // 3 :, 0] = np.log10(tolerance or 1.0)
            flight.positions[:, : COUNT // 3, 0] = np.arange(FLOWN)[:, None] * float(tolerance is None)
            return flight

    pilot = Chaotic(FLOWN)
    judge = Judge(resting(FLOWN / 10, integrator={"type": "auto", "tolerance": 1e-7}), [pilot], TOGETHER)
    assert judge.error([pilot.fly(SCHEMES["rk4"])]) == pytest.approx(FLOWN // 2 - 1)


def test_equal_steps_tell_where_adaptive_ones_lose_particles_to_rounding():
    """As they are in single precision, where the smallest tolerance is that of the first reference."""

    class Rounded(Flier):
        def fly(self, scheme, *, steps=1, tolerance=None):
            flight = super().fly(scheme, steps=steps, tolerance=tolerance)
            flight.positions[:, : COUNT // 10, 1] = 1.0 if tolerance else 0.0
            flight.positions[:, :, 0] = 0.0
            return flight

    pilot = Rounded(FLOWN)
    judge = Judge(resting(FLOWN / 10, precision="single"), [pilot], TOGETHER)
    assert judge.unknown == 0.0
    assert judge.error([pilot.fly(SCHEMES["rk4"])]) == 0.0
    assert judge.spoilt == judge.error([pilot.fly(SCHEMES[TOGETHER.judge], tolerance=1e-5)]) == 1.0


@pytest.mark.parametrize(("flown", "enough"), [(FLOWN, 2), (FLOWN // 2, 3)])
def test_pilots_that_see_all_of_a_scene_need_no_wide_margin(flown, enough):
    """The error of two steps is 0.7 of what is allowed."""
    pilot = Flier(FLOWN, flown)
    goal = {"type": "auto", "tolerance": OFF / 2 / 0.7 * FLOWN / flown}
    described = resting(FLOWN / 10, integrator=goal)
    choice = choose(described, [pilot], TOGETHER, SafeSteps(make_plan(described)))
    (euler,) = (each for each in (choice.chosen, *choice.rejected) if each.scheme == "symplectic_euler")
    assert euler.steps == enough


GRAINS = [{"type": "soft_sphere", "diameter": 0.1, "stiffness": 300, "damping": 0.1, "friction": 0.2}]


def test_grains_that_remember_contacts_are_stepped_evenly_and_compared_with_such_steps():
    described = resting(FLOWN / 10, forces=GRAINS)
    assert remembers(described)
    safe, pilot = SafeSteps(make_plan(described)), Flier(FLOWN)
    choice = choose(described, [pilot], TOGETHER, safe)
    assert (choice.chosen.scheme, choice.rejected) == (STEADY, ())
    fewest = safe.fewest(SCHEMES[STEADY], described)
    assert pilot.asked[:2] == [(SCHEMES[STEADY], FINE * fewest), (SCHEMES[STEADY], 2 * FINE * fewest)]
    assert {scheme for scheme, _ in pilot.asked} == {SCHEMES[STEADY]}


def test_grains_without_friction_remember_nothing():
    slippery = [{**GRAINS[0], "friction": 0}]
    assert not remembers(resting(1, forces=slippery))


SPRING = [{"type": "springs", "pairs": [[0, 1]], "stiffness": 4, "damping": 0.01}]
FLOOR = [{"normal": [0, 1, 0]}]
TWO = {"pair": {"positions": [[0, 1, 0], [1, 1, 0]], "mass": 0.01}}


def test_bodies_that_land_are_compared_with_steps_of_no_length():
    """Equal steps of first order, extrapolated; what chooses its steps sees nothing of the landing."""

    class Body(Flier):
        def fly(self, scheme, *, steps=1, tolerance=None):
            flight = super().fly(scheme, steps=steps, tolerance=tolerance)
            flight.positions[:, :, 0] = OFF / steps
            return flight

    described, pilot = resting(FLOWN / 10, particles=TWO, forces=SPRING, planes=FLOOR), Body(FLOWN, lands=True)
    safe = SafeSteps(make_plan(described))
    fewest = safe.fewest(SCHEMES[STEADY], described)
    judge = Judge(described, [pilot], TOGETHER, fewest)
    for steps in (1, 3):
        assert judge.error([pilot.fly(SCHEMES["rk4"], steps=steps)]) == pytest.approx(OFF / steps)
    assert judge.most_evaluations == 2 * FINE * fewest
    choice = choose(described, [pilot], TOGETHER, safe)
    assert {each.scheme for each in (choice.chosen, *choice.rejected)}.isdisjoint(ADAPTIVE)


CROWD = {"crowd": {"layout": {"type": "grid", "counts": [12, 12, 12], "spacing": 0.1}}}
LATTICE = [{"type": "springs", "stiffness": 100}]


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        pytest.param({"particles": CROWD, "forces": LATTICE, "planes": FLOOR}, True, id="a body above the ground"),
        pytest.param({"particles": CROWD, "forces": LATTICE}, False, id="a body in space"),
        pytest.param({"particles": CROWD, "planes": FLOOR}, False, id="particles that fall"),
        pytest.param({"particles": TWO, "forces": SPRING, "planes": FLOOR}, False, id="few, whose impacts are located"),
    ],
)
def test_bodies_land_where_many_particles_with_springs_meet_a_plane(parts, expected):
    assert lands(make_plan(resting(1, **parts))) is expected


@pytest.mark.parametrize(
    "parts",
    [
        pytest.param({"forces": GRAINS}, id="grains"),
        pytest.param({"particles": TWO, "forces": SPRING, "planes": FLOOR}, id="a body that lands"),
    ],
)
@pytest.mark.parametrize(("total", "least"), [(FLOWN, 1), (3 * FLOWN, UNSEEN)])
def test_contacts_that_no_pilot_sees_to_the_end_get_more_than_the_fewest_safe_steps(parts, total, least):
    described = resting(total / 10, **parts, integrator={"type": "auto", "tolerance": 1.0})
    safe = SafeSteps(make_plan(described))
    choice = choose(described, [Flier(total, lands="springs" in parts["forces"][0].values())], TOGETHER, safe)
    steps = {each.scheme: each.steps for each in (choice.chosen, *choice.rejected)}
    assert steps[STEADY] == least * safe.fewest(SCHEMES[STEADY], described)


def test_steps_of_landing_bodies_are_halved_where_much_is_lost():
    """The first two flights have a tenth of the particles elsewhere."""
    described = resting(FLOWN / 10, particles=TWO, forces=SPRING, planes=FLOOR)
    fewest = SafeSteps(make_plan(described)).fewest(SCHEMES[STEADY], described)

    class Overturned(Flier):
        def fly(self, scheme, *, steps=1, tolerance=None):
            flight = super().fly(scheme, steps=steps, tolerance=tolerance)
            flight.positions[:] = 0.0
            flight.positions[:, : COUNT // 10, 1] = 1.0 if steps <= FINE * fewest else 0.0
            return flight

    pilot = Overturned(FLOWN, lands=True)
    judge = Judge(described, [pilot], TOGETHER, fewest)
    assert [steps for _, steps in pilot.asked] == [FINE * fewest * 2**n for n in range(HALVINGS + 1)]
    assert judge.unknown == 0.0
    assert judge.error([pilot.fly(SCHEMES[STEADY], steps=1)]) == 1.0

"""How pilots are judged: in the part of their flights where they are furthest off, and from steps of what kind."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from particlecli.auto.choice import choose
from particlecli.auto.judge import FINE, FINEST, Judge
from particlecli.auto.pilot import Flight
from particlecli.auto.safe import SafeSteps
from particlecli.auto.terms import STEADY, TOGETHER, remembers
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.plan import make_plan
from tests.dynamics.scenes import body, scene

COUNT, FLOWN = 40, 8
OFF = 1e-3


@dataclass
class Flier:
    """Stands for a pilot of particles that rest; with few steps a third of them is off in the last frame.

    Attributes:
        total: frames of the scene.
        flown: those that it flies.
        asked: by scheme, with how many steps it flew.
    """

    total: int
    flown: int = FLOWN
    moves: bool = True
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
    assert pilot.asked[:2] == [(SCHEMES[STEADY], FINE * fewest), (SCHEMES[STEADY], FINEST * fewest)]
    assert {scheme for scheme, _ in pilot.asked} == {SCHEMES[STEADY]}


def test_grains_without_friction_remember_nothing():
    slippery = [{**GRAINS[0], "friction": 0}]
    assert not remembers(resting(1, forces=slippery))

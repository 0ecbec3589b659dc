"""Steps of springs stay clear of the limit that all of them set together, whatever pilots of a few frames see."""

import math

import numpy as np
import pytest

from particlecli.auto.choice import choose
from particlecli.auto.safe import MARGIN, SafeSteps
from particlecli.auto.terms import TOGETHER
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.plan import make_plan
from particlecli.stability.contacts import PACKED
from particlecli.stability.springs import fastest_modes
from tests.dynamics.scenes import body, scene

MASS, COUNT, FPS = 0.01, 40, 30


def chain(*springs):
    """A line of particles in springs of some stiffness and damping, side by side."""
    return scene(
        fps=FPS,
        particles={
            "chain": {"layout": {"type": "line", "start": [0, 0, 0], "end": [1, 0, 0], "count": COUNT}, "mass": MASS}
        },
        forces=[{"type": "springs", "stiffness": k, "damping": d, "links": ["structural"]} for k, d in springs],
        integrator={"type": "auto"},
    )


def fastest(described):
    plan = make_plan(described)
    return fastest_modes(plan.groups[0], plan.couplings).rates


def test_springs_side_by_side_are_as_stiff_and_as_damped_as_one_of_their_sums():
    both, one = (fastest(chain(*springs)) for springs in ([(60, 0.02), (30, 0.01)], [(90, 0.03)]))
    np.testing.assert_allclose(both, one, rtol=1e-6)
    square = 4 * 90 / MASS * math.sin(math.pi * (COUNT - 1) / (2 * COUNT)) ** 2
    assert np.abs(both) ** 2 == pytest.approx([square, square], rel=1e-2)
    assert both.real == pytest.approx([-0.5 * 0.03 / 90 * square] * 2, rel=1e-2)


def test_without_springs_nothing_limits_a_step():
    plan = make_plan(scene(particles={"a": body((0, 0, 0), (1, 0, 0))}))
    assert SafeSteps(plan).longest(SCHEMES["rk4"]) == math.inf


@pytest.mark.parametrize(("scheme", "limit"), [("rk4", 2 * math.sqrt(2)), ("velocity_verlet", 2.0)])
def test_no_scheme_steps_nearer_to_its_limit_than_the_margin(scheme, limit):
    described = chain((60, 0.0), (30, 0.0))
    safe = SafeSteps(make_plan(described))
    longest = MARGIN * limit / np.abs(fastest(described)).max()
    assert safe.longest(SCHEMES[scheme]) == pytest.approx(longest, rel=1e-3)
    choice = choose(described, [], TOGETHER, safe)
    (tried,) = (each for each in (choice.chosen, *choice.rejected) if each.scheme == scheme)
    assert tried.steps == math.ceil(1 / FPS / longest)
    assert tried.steps > 1


def test_spheres_that_do_not_touch_yet_are_stepped_as_if_they_were_packed():
    """In a face-centred packing waves q have the modes of Σ (1 − cos q·n) n nᵀ over the contacts n: 8 at most."""
    signs = [(1, 1), (1, -1), (-1, 1), (-1, -1)]
    contacts = np.array([(a, b, 0) for a, b in signs] + [(a, 0, b) for a, b in signs] + [(0, a, b) for a, b in signs])
    waves = np.pi * np.stack(np.meshgrid(*[np.linspace(0, 1, 9)] * 3), -1).reshape(-1, 3)
    parts = np.einsum("wc,ci,cj->wij", 1 - np.cos(waves @ contacts.T), contacts, contacts) / 2
    assert np.linalg.eigvalsh(parts).max() == pytest.approx(PACKED)
    apart = scene(
        fps=FPS,
        particles={
            "grains": {"layout": {"type": "line", "start": [0, 0, 0], "end": [9, 0, 0], "count": 4}, "mass": MASS}
        },
        forces=[{"type": "soft_sphere", "diameter": 0.1, "stiffness": 300}],
    )
    limit = 2 * math.sqrt(2) / math.sqrt(PACKED * 300 / MASS)
    assert SafeSteps(make_plan(apart)).longest(SCHEMES["rk4"]) == pytest.approx(MARGIN * limit, rel=1e-3)

from __future__ import annotations

import numpy as np
import pytest

from particlecli import runtime
from particlecli.accuracy.linear_analysis import linearized
from particlecli.accuracy.rates import fastest_rate, is_linear, turns
from particlecli.accuracy.states import states_at_birth
from particlecli.dynamics.plan import make_plan
from particlecli.scene.load import load_scene
from particlecli.stability.modes import modes_of

FORCES = {
    "gravity": "{type: gravity}",
    "point_gravity": "{type: point_gravity, strength: 3, softening: 0.2}",
    "repulsion": "{type: point_gravity, strength: -3}",
    "orbit": "{type: orbit, strength: 2, exponent: 2.5}",
    "vortex": "{type: vortex, swirl: 2, pull: 1, axis: [1, 2, 3]}",
    "drag": "{type: drag, coefficient: 7}",
    "drag_in_shear": "{type: drag, coefficient: 7, flow: shear}",
    "drag_in_noise": "{type: drag, coefficient: 7, flow: noise}",
    "quadratic_drag": "{type: quadratic_drag, coefficient: 4, flow: whirl}",
    "force_field": '{type: force_field, force: ["-x*y + 3*v", "sin(4*z) - 3*u", "-x**3 - w"]}',
    "potential": '{type: force_field, potential: "8*x**2 + y**4 + z**2*x"}',
    "spring": '{type: force_field, force: ["-4*x - u", "-4*y", "-4*z"]}',
}
FLOWS = """\
flows:
  still: [{type: uniform, velocity: [1, 2, 3]}]
  shear: [{type: expression, velocity: ["2*y", "-2*x", "0.3*z"]}]
  wavy: [{type: expression, velocity: ["sin(5*y)", "cos(5*x)", "t"]}]
  noise: [{type: curl_noise, length: 0.7, speed: 1.5, octaves: 4}]
  whirl: [{type: vortex, circulation: 2, core: 0.2}]
  gyres: [{type: double_gyre, amplitude: 0.8, swing: 0.4, period: 2, length: 1.3}]
  waves: [{type: abc, amplitudes: [1, -2, 0.5], wave_number: 3}]
  chessboard: [{type: taylor_green, speed: -1.5, length: 0.8, viscosity: 0.01}]
"""
LINEAR = {"gravity", "drag", "drag_in_shear", "spring", "carried_by_still", "carried_by_shear"}


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    shape = "shape: {type: ball, radius: 1.5}, rate: 200"
    moved = f"{shape}, speed: {{uniform: [0, 5]}}, direction: {{spread: 180}}, mass: {{uniform: [0.5, 2]}}"
    lines = [f"  {name}: {{{moved}}}" for name in FORCES]
    lines += [
        f"  carried_by_{flow}: {{{shape}, motion: first_order, flow: {flow}}}"
        for flow in ("still", "shear", "wavy", "noise", "whirl", "gyres", "waves", "chessboard")
    ]
    forces = [f"  - {text[:-1]}, on: [{name}]}}" for name, text in FORCES.items()]
    text = "\n".join(["duration: 1", "precision: double", FLOWS + "emitters:", *lines, "forces:", *forces])
    path = tmp_path_factory.mktemp("rates") / "rates.yaml"
    path.write_text(text)
    return make_plan(load_scene(path))


@pytest.fixture(scope="module")
def system(plan):
    runtime.start("double", 1)
    from particlecli.dynamics.system import System

    return System(plan)


NEAR = {"carried_by_gyres": 10}
"""How many times too large a bound may be, where more than usual: there the flow shears more than it turns."""

NAMES = [
    *FORCES,
    *(f"carried_by_{flow}" for flow in ("still", "shear", "wavy", "noise", "whirl", "gyres", "waves", "chessboard")),
]


@pytest.mark.parametrize("name", NAMES)
def test_no_mode_is_faster_than_the_bound_and_the_bound_is_not_far_off(plan, system, name):
    from particlecli.dynamics.probe import Probe

    (group,) = (each for each in plan.groups if each.name == name)
    states = states_at_birth(group, 150)
    bound = fastest_rate(group, plan.flows, states)
    _, by_position, by_velocity = linearized(Probe(system.groups[name].motion, "double"), states)
    rates = modes_of(by_position, by_velocity if group.newtonian else None).rates
    fastest = np.abs(rates).max()
    assert fastest <= bound * (1 + 1e-9)
    assert bound <= NEAR.get(name, 4) * fastest + 1e-12


@pytest.mark.parametrize("name", ["drag_in_noise", "quadratic_drag", "force_field", "potential", "carried_by_wavy"])
def test_jacobians_are_slopes_of_the_derivative(plan, system, name):
    from particlecli.dynamics.probe import Probe

    (group,) = (each for each in plan.groups if each.name == name)
    states = states_at_birth(group, 20)
    probe = Probe(system.groups[name].motion, "double")
    jacobians = probe.jacobian(states.motion, states.times, states.inverse_masses)
    width = 1e-5
    for column in range(len(states.motion)):
        shift = np.zeros_like(states.motion)
        shift[column] = width
        up, down = (
            probe.derivative(states.motion + sign * shift, states.times, states.inverse_masses)[-3:] for sign in (1, -1)
        )
        slopes = ((up - down) / (2 * width)).T
        found = jacobians[column // 3, :, :, column % 3]
        assert found == pytest.approx(slopes, rel=1e-6, abs=1e-6 * np.abs(jacobians).max())
        assert np.abs(jacobians).max() > 0.1


def test_linear_motion_is_known_as_such(plan):
    assert {group.name for group in plan.groups if is_linear(group, plan.flows)} == LINEAR


def test_forces_that_may_turn_velocities_are_known(plan):
    assert {group.name for group in plan.groups if turns(group)} == {"force_field", "spring"}


def test_a_body_in_the_centre_of_a_force_has_no_bound(tmp_path):
    path = tmp_path / "centre.yaml"
    path.write_text(
        "duration: 1\nparticles: {p: {positions: [[0, 0, 0]]}}\nforces: [{type: point_gravity, strength: 1}]\n"
    )
    plan = make_plan(load_scene(path))
    assert fastest_rate(plan.groups[0], plan.flows, states_at_birth(plan.groups[0], 1)) is None

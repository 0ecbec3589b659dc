from __future__ import annotations

import math

import numpy as np
import pytest

from particlecli.accuracy.advice import advice, verdict
from particlecli.accuracy.linear_analysis import analyze
from particlecli.accuracy.stability_plot import draw, plot_stability
from particlecli.errors import UsageError
from particlecli.scene.load import load_scene

SCENE = """\
duration: 2
fps: 20
particles:
  bob: {positions: [[1, 0, 0]]}
  planet: {positions: [[2, 0, 0], [0, 0, 0]]}
  stone: {positions: [[0, 0, 0]]}
emitters:
  dust: {motion: first_order, flow: eddy, rate: 5000}
flows: {eddy: [{type: expression, velocity: ["-3*y", "3*x", 0]}]}
forces:
  - {type: force_field, force: ["-x**3", "-y", "-z"], on: [bob]}
  - {type: point_gravity, strength: 8, on: [planet]}
  - {type: gravity, on: [stone]}
integrator: {type: rk4, dt: 0.01}
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("linear") / "mixed.yaml"
    path.write_text(SCENE)
    return load_scene(path)


@pytest.fixture(scope="module")
def analysis(scene):
    return analyze(scene, threads=1)


@pytest.fixture
def groups(analysis):
    return {group.name: group for group in analysis.groups}


def test_rates_are_those_of_the_forces(groups):
    assert groups["bob"].position_rate == pytest.approx(math.sqrt(3))
    assert groups["planet"].position_rate == pytest.approx(math.sqrt(2))  # √(2 GM/r³)
    assert groups["dust"].of_kind("oscillation").rates.imag.max() == pytest.approx(3.0)
    assert groups["stone"].acceleration == pytest.approx(9.80665)


def test_what_rules_and_what_is_linear(groups):
    rulers = {name: group.ruler for name, group in groups.items()}
    assert rulers == {"bob": "position", "planet": "position", "stone": "nothing", "dust": "flow"}
    assert {name for name, group in groups.items() if group.linear} == {"stone", "dust"}


def test_a_singular_particle_is_left_out_and_many_are_sampled(groups):
    assert (groups["planet"].particles, groups["planet"].sampled) == (2, 1)
    assert groups["dust"].sampled < groups["dust"].particles == 10_000


def test_the_group_that_limits_is_named(analysis):
    limit = analysis.limits["rk4"]
    assert limit.group == "dust"
    assert limit.step == pytest.approx(2 * math.sqrt(2) / 3)
    assert "velocity_verlet" not in analysis.limits  # a first-order group has no velocity
    assert "rk4 is stable" in verdict(analysis)


def test_advice_tells_what_rules(groups):
    assert "parabolas" in advice(groups["stone"], 0.05)
    assert "euler spirals outwards" in advice(groups["dust"], 0.05)


def test_the_state_at_a_time_is_looked_at(tmp_path):
    path = tmp_path / "later.yaml"
    path.write_text(SCENE.replace(", [0, 0, 0]]}", "]}"))  # nothing in the singular centre of the attraction
    later = analyze(load_scene(path), at=0.5, threads=1)
    (bob,) = (group for group in later.groups if group.name == "bob")
    assert 0.5 < bob.position_rate < math.sqrt(3)  # ∂a/∂x falls with x², and x with time


def test_times_outside_of_the_scene_are_refused(scene):
    for time in (-1.0, 2.1, math.nan):
        with pytest.raises(UsageError, match="not a time of the scene"):
            analyze(scene, at=time)


def test_the_plot_has_a_panel_for_each_scheme(analysis, tmp_path):
    panels = [axes for axes in draw(analysis).axes if axes.get_visible()]
    assert [axes.get_title(loc="left") for axes in panels] == list(analysis.limits)
    files = [tmp_path / name for name in ("a.svg", "b.svg", "c.png")]
    for file in files:
        plot_stability(analysis, file)
    assert files[0].read_bytes() == files[1].read_bytes()
    assert files[2].read_bytes().startswith(b"\x89PNG")
    assert np.isfinite([limit.step for limit in analysis.limits.values() if limit.rate]).all()

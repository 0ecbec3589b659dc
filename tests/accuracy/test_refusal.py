from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

import particlecli
from particlecli import runtime
from particlecli.accuracy.judge import judge as judge_by_scipy
from particlecli.accuracy.references import compare_with_known
from particlecli.accuracy.refusal import refuse_unstable, rounded_down
from particlecli.dynamics.plan import make_plan
from particlecli.errors import SimulationError
from particlecli.run import RunOptions, run
from particlecli.scene.load import load_scene

ROOT = Path(particlecli.__file__).parents[1]
SHIPPED = sorted([*(ROOT / "scenes").rglob("*.yaml"), *(ROOT / "particlecli/scene/templates").glob("*.yaml")])

PELLETS = """\
duration: 1
fps: 30
particles:
  pellets: {positions: [[0, 1, 0], [1, 1, 0]], velocities: [[1, 0, 0], [2, 0, 0]], mass: 1.0e-3}
forces: [{type: gravity}, {type: drag, coefficient: 30}]
integrator: {type: rk4, dt: 0.0334}
"""
"""Linear drag with k·dt/m = 1000."""

BOB = """\
duration: 10
fps: 100
particles: {bob: {positions: [[1, 0, 0]]}}
forces: [{type: force_field, force: ["-100*x", "-100*y", "-100*z"]}]
integrator: {type: euler, dt: 0.01}
"""


@pytest.fixture
def judge(tmp_path):
    """Judges a scene as a run does, with kernels that are compiled only when they are needed."""

    def judge(text, *overrides, kernels=True):
        path = tmp_path / "scene.yaml"
        path.write_text(text)
        scene = load_scene(path, overrides)
        plan = make_plan(scene)
        system = None
        if kernels:
            runtime.start(scene.precision, 1)
            from particlecli.dynamics.system import System

            system = System(plan)
        refuse_unstable(SimpleNamespace(scene=scene, plan=plan, system=system))

    return judge


EXPLICIT = ["euler", "midpoint", "rk3", "rk4", "symplectic_euler"]
STIFF = ["implicit_euler", "implicit_midpoint", "trapezoidal", "tr_bdf2", "radau_iia", "exact"]


@pytest.mark.parametrize("scheme", EXPLICIT)
def test_stiff_drag_is_refused(judge, scheme):
    with pytest.raises(SimulationError) as caught:
        judge(PELLETS, f"integrator.type={scheme}")
    message = str(caught.value)
    assert caught.value.exit_code == 3
    assert f"group pellets: {scheme} is unstable at steps of 0.0333 s; a decay at 3e+04 1/s" in message
    for remedy in STIFF:
        assert remedy in message
    assert "allow_unstable: true" in message


@pytest.mark.parametrize("scheme", STIFF)
def test_implicit_and_exact_schemes_take_it_without_a_look(judge, scheme):
    judge(PELLETS, f"integrator.type={scheme}", kernels=False)


def test_adaptive_schemes_choose_a_stable_step(judge):
    judge(PELLETS, "integrator.type=dop853", "integrator.dt=1", kernels=False)


def test_allowed_when_asked_for(judge):
    judge(PELLETS, "integrator.allow_unstable=true", kernels=False)


@pytest.mark.parametrize("scheme", EXPLICIT)
def test_the_shorter_step_that_is_proposed_is_accepted_and_twice_it_is_not(judge, scheme):
    with pytest.raises(SimulationError) as caught:
        judge(PELLETS, f"integrator.type={scheme}")
    proposed = float(re.search(r"dt: (\S+) or less", str(caught.value)).group(1))
    judge(PELLETS, f"integrator.type={scheme}", f"integrator.dt={proposed}")
    with pytest.raises(SimulationError):
        judge(PELLETS, f"integrator.type={scheme}", f"integrator.dt={2 * proposed}")


def test_a_step_just_short_of_the_limit_is_accepted_and_one_past_it_refused(judge):
    limit = 2.785293563405 / 3e4
    judge(PELLETS, "duration=0.01", "fps=1000", f"integrator.dt={0.99 * limit}")
    with pytest.raises(SimulationError, match=f"stable up to {limit:.3g}"):
        judge(PELLETS, "duration=0.01", "fps=1000", f"integrator.dt={1.1 * limit}")


def test_growth_that_shows_is_refused_and_a_little_inaccuracy_is_not(judge):
    """Euler makes the spring's amplitude (1 + ω²dt²)^(steps/2) times as large: 145 in 10 s, 1.6 in 1 s."""
    with pytest.raises(SimulationError, match=r"an oscillation of 1.59 Hz would grow 145-fold"):
        judge(BOB)
    judge(BOB, "duration=1")
    for scheme in ("midpoint", "rk4", "velocity_verlet"):
        judge(BOB, f"integrator.type={scheme}")


@pytest.mark.parametrize(("step", "refused"), [(0.19, False), (0.21, True)])
def test_verlet_is_stable_up_to_its_limit(judge, step, refused):
    changes = ("fps=1", "integrator.type=velocity_verlet", f"integrator.dt={step}", f"fps={1 / step}")
    if not refused:
        judge(BOB, *changes)
        return
    with pytest.raises(SimulationError, match=r"stable up to 0\.2\b"):
        judge(BOB, *changes)


def test_resolved_motion_that_does_not_last_is_left_to_the_error_estimate(judge):
    pendulum = BOB.replace('"-100*x"', '"-100*sin(x)"')
    judge(pendulum)
    with pytest.raises(SimulationError):
        judge(pendulum, "fps=10", "integrator.dt=0.1")


def test_motion_that_grows_by_itself_is_not_the_fault_of_the_scheme(judge):
    saddle = BOB.replace("-100*", "100*")
    for scheme in ("euler", "rk4", "velocity_verlet", "implicit_euler"):
        judge(saddle, f"integrator.type={scheme}", "fps=5", "integrator.dt=0.2")


FAST = """\
duration: 2
emitters:
  shots: {rate: 50, speed: 300, mass: 0.01, lifetime: 1}
forces: [{type: quadratic_drag, coefficient: 0.001}]
integrator: {type: rk4, dt: 0.034}
"""


def test_quadratic_drag_counts_at_the_speed_of_birth(judge):
    judge(FAST, kernels=False)  # 2 k v / m = 60 1/s, times dt = 2
    with pytest.raises(SimulationError, match=r"group shots: .* a decay at 120 1/s"):
        judge(FAST, "emitters.shots.speed=600")


def test_light_particles_among_heavy_ones_are_found(judge):
    mixed = PELLETS.replace("mass: 1.0e-3", "masses: [1, 1.0e-3]")
    with pytest.raises(SimulationError, match=r"a decay at 3e\+04 1/s"):
        judge(mixed)
    judge(mixed.replace("[1, 1.0e-3]", "[1, 2]"), kernels=False)


def test_forces_that_turn_velocities_are_looked_at_more_closely(judge):
    turning = BOB.replace('"-100*x", "-100*y", "-100*z"', '"20*v", "-20*u", "0"').replace(
        "positions: [[1, 0, 0]]", "positions: [[0, 0, 0]], velocities: [[1, 0, 0]]"
    )
    with pytest.raises(SimulationError, match=r"symplectic_euler is unstable .* an oscillation of 3.18 Hz"):
        judge(turning, "integrator.type=symplectic_euler")
    judge(turning, "integrator.type=rk4")


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_scenes_run_and_need_no_kernel_to_be_judged(path):
    scene = load_scene(path)
    refuse_unstable(SimpleNamespace(scene=scene, plan=make_plan(scene), system=None))


def test_gravity_alone_needs_no_kernel_whatever_the_step(judge):
    judge(BOB.replace('{type: force_field, force: ["-100*x", "-100*y", "-100*z"]}', "{type: gravity}"), kernels=False)


def test_a_refused_run_leaves_nothing(tmp_path):
    path = tmp_path / "pellets.yaml"
    path.write_text(PELLETS)
    out = tmp_path / "out"
    with pytest.raises(SimulationError, match="unstable"):
        run(load_scene(path), RunOptions(folder=out))
    assert not out.exists()


def test_numbers_are_rounded_down():
    assert [rounded_down(x) for x in (0.0199, 123.0, 5.0e-5)] == pytest.approx([0.019, 120, 5.0e-5])


ROPE = """\
duration: 1
fps: 10
particles:
  rope:
    layout: {type: line, start: [0, 0, 0], end: [0, -1, 0], count: 21}
    mass: 0.01
    pins: [{where: y > -0.01}]
forces: [{type: gravity}, {type: springs, stiffness: 1000, links: [structural]}]
integrator: {type: velocity_verlet, dt: 0.001}
"""
"""Its fastest mode has ω ≈ 2 √(k/m) = 632 1/s, nearly: velocity_verlet is stable up to 2/ω = 3.2 ms."""


@pytest.mark.parametrize("dt", [0.001, 0.0031])
def test_springs_within_the_limit_run(judge, dt):
    judge(ROPE, f"integrator.dt={dt}", kernels=False)


@pytest.mark.parametrize(
    "change", ["integrator.dt=0.0034", "integrator.type=rk4 integrator.dt=0.005", "forces.1.damping=20"]
)
def test_springs_too_stiff_for_the_step_are_refused(judge, change):
    extra = ["integrator.type=rk4"] if "damping" in change else []
    with pytest.raises(SimulationError, match=r"group rope: .* unstable .*\n  dt: .*\n  type: .*\n  allow_unstable"):
        judge(ROPE, *change.split(), *extra, kernels=False)


def test_frames_in_python_and_checks_are_refused_as_runs_are(tmp_path):
    path = tmp_path / "pellets.yaml"
    known = "{at: 1, group: pellets, particles: [0], velocity: [0, 0, 0], tolerance: 1}"
    path.write_text(f"{PELLETS}reference: [{known}]\n")
    unstable = load_scene(path)
    for refusing in (particlecli.simulate, compare_with_known, judge_by_scipy):
        with pytest.raises(SimulationError, match="rk4 is unstable"):
            refusing(unstable)

"""Studies of error against time find what is known: orders, the closed form, and where SciPy goes as well."""

import json

import numpy as np
import pytest

from particlecli.accuracy.peers import why_not
from particlecli.accuracy.tracks import deviation
from particlecli.accuracy.work_precision import Study, work_precision
from particlecli.accuracy.work_precision_plot import save_plot
from particlecli.dynamics.plan import make_plan
from particlecli.errors import UsageError
from particlecli.render.camera import View
from tests.dynamics import scenes

OMEGA = np.array([3.0, 4.0, 5.0])


def oscillators(**parts):
    return scenes.scene(
        title="Oscillators",
        particles={
            "bodies": {
                "positions": [[1, 0, 0.2], [0, 1.5, 0], [0.3, -0.4, 1]],
                "velocities": [[0, 1, 0], [2, 0, 0], [0, 0, 1]],
            }
        },
        forces=[{"type": "force_field", "potential": "4.5*x**2 + 8*y**2 + 12.5*z**2"}],
        **parts,
    )


def closed_form(scene):
    group = scene.particles["bodies"]
    x, v = np.array(group.positions), np.array(group.velocities)
    phase = OMEGA * (np.arange(scene.frame_count) / scene.fps)[:, None, None]
    return x * np.cos(phase) + v / OMEGA * np.sin(phase)


@pytest.fixture(scope="module")
def study():
    settings = Study(integrators=("midpoint", "rk4"), longest=0.3, threads=1)
    return work_precision(oscillators(), settings)


def test_the_reference_is_the_closed_form_to_what_it_says(study):
    error = np.abs(study.reference.tracks["bodies"].positions - closed_form(study.scene)).max()
    assert error < 1e-11
    assert error < 10 * study.known
    assert study.known < 1e-10
    assert study.reference.extent == pytest.approx(2.0, rel=0.5)


def test_measured_orders_are_the_declared_ones(study):
    assert study.orders["midpoint", "double"] == pytest.approx(2, abs=0.2)
    assert study.orders["rk4", "double"] == pytest.approx(4, abs=0.2)


def test_single_precision_stops_at_its_floor(study):
    assert 1e-8 < study.floors["single"] < 3e-6
    assert study.floors.get("double", 0.0) < 1e-10
    best = {
        precision: min(run.error for run in study.runs if run.precision == precision)
        for precision in ("single", "double")
    }
    assert best["double"] < 1e-3 * best["single"]


def test_energy_drifts_with_the_error(study):
    coarse, *_, fine = (run for run in study.runs if run.integrator == "rk4" and run.precision == "double")
    assert 1e-4 < coarse.energy_drift < 1.0
    assert fine.energy_drift < 1e-7


def test_runs_tell_what_they_cost(study):
    for run in study.runs:
        if run.peer:
            continue
        assert run.seconds > 0
        assert run.particle_steps == 3 * run.steps * (study.scene.frame_count - 1)
        stages = {"midpoint": 2, "rk4": 4}[run.integrator]
        assert run.evaluations == stages * run.particle_steps


def test_peers_come_nearer_with_smaller_tolerances(study):
    for name in ("SciPy DOP853", "SciPy LSODA"):
        errors = [run.error for run in study.runs if run.integrator == name]
        assert errors[-1] < 1e-9 < 1e-5 < errors[0]


def test_the_front_ends_with_the_best_and_all_of_it_can_be_written_as_json(study):
    written = json.loads(json.dumps(study.to_dict()))
    front = [run["error"]["metres"]["worst_frame"]["p95"] for run in written["runs"] if run["on_pareto_front"]]
    assert min(front) == min(run.error for run in study.runs)
    assert len(front) == len(study.front) > 2


def test_the_plot_names_every_integrator_and_what_limits_it(study, tmp_path):
    svg, png = tmp_path / "plot.svg", tmp_path / "plot.png"
    save_plot(study, [svg, png])
    text = svg.read_text()
    for words in ("Oscillators", "rk4, p = 4.0", "midpoint, p = 2.0", "SciPy LSODA", "Pareto front", "½ pixel"):
        assert words in text
    assert "roundoff floor in single precision" in text
    assert png.read_bytes().startswith(b"\x89PNG")
    save_plot(study, [again := tmp_path / "again.svg"])
    assert again.read_text() == text


def test_particles_that_come_and_go_are_followed_by_peers_too():
    scene = scenes.scene(
        precision="double",
        emitters={
            "sparks": {
                "rate": 40,
                "bursts": [{"time": 0.35, "count": 6}],
                "speed": {"uniform": [1, 3]},
                "direction": {"spread": 40},
                "mass": {"uniform": [1, 2]},
                "lifetime": {"uniform": [0.15, 0.5]},
            }
        },
        forces=[{"type": "gravity"}, {"type": "drag", "coefficient": 2}],
    )
    study = work_precision(scene, Study(("rk4",), tolerances=(1e-10,), steps=(2, 4), particles=30, threads=1))
    dop853, lsoda = (run for run in study.runs if run.peer)
    assert dop853.error < 1e-11
    assert lsoda.error < 1e-8
    assert dop853.deviation.unmatched == 0.0
    assert [run.steps for run in study.runs if not run.peer] == [2, 4]
    assert study.no_peers == ""
    assert study.particles == {"sparks": (30, 46)}


def test_planes_leave_peers_out():
    falling = {
        "particles": {"dust": {"positions": [[0, 1, 0]]}},
        "forces": [{"type": "gravity"}],
        "planes": [{"restitution": 0.5}],
    }
    assert "dust meets planes" in why_not(make_plan(scenes.scene(**falling)))
    assert why_not(make_plan(scenes.scene(**falling | {"planes": []}))) == ""


def test_integrators_must_suit_the_scene():
    with pytest.raises(UsageError, match="yoshida4 cannot run this scene; euler, "):
        work_precision(
            scenes.scene(particles={"a": {"positions": [[0, 0, 0]]}}, forces=[{"type": "drag", "coefficient": 1}]),
            Study(integrators=("yoshida4",)),
        )
    with pytest.raises(UsageError, match="second frame"):
        work_precision(oscillators(duration=0.001), Study())


def test_a_wrong_run_is_told_from_the_reference(study):
    view = View.of(study.scene.camera, 1280, 720)
    wrong = {name: track.of(track.ids) for name, track in study.reference.tracks.items()}
    wrong["bodies"].positions[-1, 0] += [0, 0, 1e-3]
    assert deviation(wrong, study.reference.tracks, view).final.largest == pytest.approx(1e-3)


@pytest.mark.slow
def test_a_study_ends_in_time_and_says_what_it_left_out():
    pair = {"positions": [[0, 0, 0], [1, 0, 0]], "velocities": [[0, 0, 0], [0, 1.2, 0]]}
    described = scenes.scene(
        particles={"pair": pair},
        forces=[{"type": "springs", "stiffness": 40, "pairs": [[0, 1]]}],
        integrator={"type": "rk4", "dt": 0.05},
        duration=40,
        precision="double",
    )
    hurried = work_precision(described, Study(budget=1e-3, longest=0.05, threads=1))
    assert {run.integrator for run in hurried.runs} == {"rk4", "velocity_verlet"}  # the scene's own, and the next
    assert "midpoint (double)" in hurried.left_out
    assert (hurried.scene.frame_count, hurried.frames_of) == (6, 401)
    assert hurried.to_dict()["left_out"] == list(hurried.left_out)
    best = min(run.error for run in hurried.runs)
    assert best < 1e-6

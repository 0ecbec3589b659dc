"""Systems: births exact in time, deaths by cause, inert additions, threads, the solver interface."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from particlecli import runtime, simulate
from particlecli.errors import SceneError, SimulationError
from particlecli.simulate import Simulation
from tests.dynamics.scenes import body, scene, system

SPARKS = {
    "rate": 300,
    "shape": {"type": "disc", "radius": 0.2},
    "direction": {"axis": [0, 1, 0], "spread": 20},
    "speed": {"uniform": [1, 3]},
    "mass": {"log_normal": [1e-3, 0.3]},
    "lifetime": {"uniform": [0.2, 0.9]},
    "temperature": {"normal": [1500, 100]},
    "cooling": {"rate": {"uniform": [0.5, 1.5]}, "ambient": 300},
    "dies": {"colder_than": 900},
}
PARTS = {
    "integrator": {"type": "symplectic_euler"},
    "flows": {"air": [{"type": "curl_noise", "length": 0.5, "speed": 1, "lifetime": 1}]},
    "emitters": {"sparks": SPARKS},
    "forces": [{"type": "gravity"}, {"type": "drag", "coefficient": 2e-3, "flow": "air"}],
    "planes": [{"restitution": 0.4, "friction": 0.3}],
}


def digest(frames):
    import hashlib

    found = hashlib.sha256()
    for frame in frames:
        group = frame.groups["sparks"]
        for array in (group.ids, group.positions, group.velocities, group.ages, group.temperatures):
            found.update(np.ascontiguousarray(array).tobytes())
    return found.hexdigest()


def test_same_scene_same_bits_for_any_number_of_threads():
    digests = {digest(simulate(scene(**PARTS), threads=threads)) for threads in (1, 2, 3, 2)}
    assert len(digests) == 1
    assert digest(simulate(scene(**PARTS, seed=1))) not in digests


def test_inert_additions_leave_every_bit_as_it_was():
    more = {
        **PARTS,
        "flows": {"unused": [{"type": "uniform", "velocity": [1, 2, 3]}], **PARTS["flows"]},
        "emitters": {
            "never": {"rate": 0},
            "later": {"bursts": [{"time": 50, "count": 3}]},
            **PARTS["emitters"],
        },
        "particles": {"bystander": body((5, 5, 5), (0, 0, 0))},
        "planes": [*PARTS["planes"], {"point": [0, -50, 0], "normal": [0.1, 1, 0.2]}],
    }
    assert digest(simulate(scene(**more))) == digest(simulate(scene(**PARTS)))


def test_what_is_not_used_is_not_built():
    plan = Simulation(
        scene(
            flows={"unused": [{"type": "uniform", "velocity": [1, 2, 3]}]},
            emitters={"never": {"rate": 0}},
            particles={"a": body((0, 0, 0), (0, 0, 0))},
        )
    ).plan
    assert [group.name for group in plan.groups] == ["a"]
    assert plan.unused_flows == ["unused"]
    assert plan.empty_groups == ["never"]
    assert plan.groups[0].components == ("x", "y", "z", "u", "v", "w")
    assert plan.groups[0].bytes_per_particle == 24


def test_groups_that_nobody_is_born_into_have_every_array_of_their_frames():
    late = {**SPARKS, "rate": 0, "bursts": [{"time": 100, "count": 5}]}
    frame = next(iter(simulate(scene(emitters={"late": late}))))
    nobody = frame.groups["late"]
    assert nobody.velocities.shape == nobody.positions.shape == (0, 3)
    assert nobody.ages.shape == nobody.lifetimes.shape == nobody.temperatures.shape == (0,)


def test_births_do_not_depend_on_step_or_frame_rate():
    ballistic = {**SPARKS, "dies": {}, "lifetime": 5}
    tables = []
    for fps, dt in ((10, 0.05), (10, 0.01), (40, 0.003)):
        frames = list(
            simulate(scene(fps=fps, precision="double", emitters={"sparks": ballistic}, integrator={"dt": dt}))
        )
        group = frames[-1].groups["sparks"]
        tables.append((group.ids, group.positions, group.velocities, group.ages))
    for table in tables[1:]:
        for found, expected in zip(table, tables[0], strict=True):
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


def test_a_newborn_moves_from_its_birth_on():
    frame = list(
        simulate(
            scene(
                precision="double",
                emitters={"sparks": {"rate": 50, "speed": 2.0}},
                forces=[{"type": "gravity", "acceleration": [0, -10, 0]}],
                integrator={"type": "rk4", "dt": 0.05},
            )
        )
    )[-1]
    group = frame.groups["sparks"]
    age = 1.0 - (np.arange(50) + 0.5) / 50
    np.testing.assert_allclose(group.ages, age, atol=1e-12)
    np.testing.assert_allclose(group.positions[:, 1], 2 * age - 5 * age**2, atol=1e-12)


def test_lifetimes_end_and_causes_are_counted():
    simulation = Simulation(scene(emitters={"sparks": {"rate": 100, "lifetime": 0.25}}))
    for frame in simulation:
        assert all(frame.groups["sparks"].ages < 0.25)
    assert simulation.births == {"sparks": 100}
    assert simulation.deaths["sparks"] == {"expired": simulation.births["sparks"] - simulation.alive}
    assert simulation.alive == 25


def test_leaving_the_domain_is_a_death_and_order_is_kept():
    simulation = Simulation(
        scene(
            particles={
                "a": {
                    "layout": {"type": "line", "start": [0, 0, 0], "end": [1, 0, 0], "count": 101},
                    "velocity": [1, 0, 0],
                    "dies": {"outside": {"min": [-1, -1, -1], "max": [1.5, 1, 1]}},
                }
            }
        )
    )
    last = list(simulation)[-1].groups["a"]
    assert simulation.deaths["a"]["outside"] == 101 - len(last)
    assert list(last.ids) == list(range(len(last)))
    assert len(last) in (50, 51)


NEEDLE = {
    "particles": {"a": {"positions": [[3, 0, 0], [1, 0, 0]], "velocities": [[0, 0, 0], [-1, 0, 0]]}},
    "forces": [{"type": "force_field", "force": ["where(x < 0.5, 1/(x - x), 0)", 0, 0]}],
    "integrator": {"type": "euler", "dt": 0.025},
}


def test_a_non_finite_particle_stops_the_run_and_is_named():
    with pytest.raises(SimulationError, match=r"group a, particle 1.*t = 0\.5.*x = 0\.\d+.*integrator\.dt"):
        list(simulate(scene(**NEEDLE)))


def test_non_finite_particles_are_dropped_where_the_scene_says_so():
    parts = {**NEEDLE, "particles": {"a": {**NEEDLE["particles"]["a"], "dies": {"non_finite": True}}}}
    simulation = Simulation(scene(**parts))
    last = list(simulation)[-1]
    assert simulation.deaths["a"] == {"non_finite": 1}
    np.testing.assert_array_equal(last.groups["a"].ids, [0])


def test_more_memory_than_there_is_is_refused_before_anything_is_allocated():
    with pytest.raises(SceneError, match="GB"):
        Simulation(scene(particles={"a": {"layout": {"type": "ball", "radius": 1, "count": 2 * 10**9}}}))


def test_scipy_drives_a_scene_through_the_solver_interface():
    made = system(
        precision="double",
        particles={
            "bodies": {
                "positions": [[1, 2, 0], [0, 1, 1]],
                "velocities": [[1, 0, 0], [0, 0, 2]],
                "masses": [1, 3],
            },
            "tracers": {
                "positions": [[1, 0, 0]],
                "motion": "first_order",
                "flow": "spin",
                "temperature": 900,
                "cooling": {"rate": 1.0, "ambient": 300},
            },
        },
        flows={"spin": [{"type": "expression", "velocity": ["-y", "x", "0.1*t"]}]},
        forces=[{"type": "gravity"}, {"type": "drag", "coefficient": 0.7, "flow": "spin"}],
        integrator={"type": "rk4", "dt": 0.002},
    )
    start = made.get_state()
    assert start.shape == (made.dim,) == (2 * 6 + 4,)

    def slope(t, y):
        made.set_state(y)
        return made.derivative(t)

    truth = solve_ivp(slope, (0, 1), start, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    made.set_state(start)
    for frame in range(1, 11):
        made.advance(frame / 10)
    np.testing.assert_allclose(made.get_state(), truth, rtol=1e-8)
    with pytest.raises(ValueError, match="shape"):
        made.set_state(start[:-1])


def test_planning_never_loads_taichi():
    code = (
        "import sys; from particlecli.scene.model import Scene; from particlecli.dynamics.plan import make_plan;"
        "make_plan(Scene.model_validate({'duration': 1, 'emitters': {'a': {'rate': 5}}}));"
        "assert 'taichi' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_runtime_starts_again_only_for_other_settings():
    runtime.start("single", 2)
    import taichi as ti

    field = ti.field(ti.f32, shape=3)
    field[0] = 7.0
    runtime.start("single", 2)
    assert field[0] == 7.0

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from particlecli import runtime
from particlecli.accuracy.conserved import Conserved
from particlecli.accuracy.prices import Besides
from particlecli.dynamics.plan import make_plan
from particlecli.scene.model import Scene
from particlecli.simulate import Simulation

BODIES = {"positions": [[1, 0, 0], [-1, 0, 0]], "velocities": [[0, 0.4, 0], [0, -0.4, 0.1]], "masses": [1, 2]}


def scene(*forces: dict[str, object], scheme: str = "velocity_verlet", **more: object) -> Scene:
    parts = {"particles": {"stars": BODIES}, "forces": [{"type": "attraction", "strength": 1}, *forces]}
    rest = {"duration": 2, "fps": 10, "precision": "double", "integrator": {"type": scheme, "dt": 0.02}}
    return Scene.model_validate({**parts, **rest, **more})


def drifts(described: Scene) -> dict[str, float]:
    simulation = Simulation(described, threads=1)
    conserved = Conserved(simulation)
    for frame in simulation:
        conserved.watch(frame)
    return conserved.result()


def names(described: Scene) -> list[str]:
    """What is looked at; nothing is compiled."""
    runtime.start(described.precision, 1)
    from particlecli.dynamics.system import System

    plan = make_plan(described)
    simulation = SimpleNamespace(scene=described, plan=plan, system=System(plan))
    return Conserved(cast(Simulation, simulation)).names


def test_a_symmetric_scheme_keeps_momenta_to_rounding_and_energy_nearly() -> None:
    found = drifts(scene())
    assert list(found) == ["energy", "momentum", "angular momentum"]
    assert found["momentum"] < 1e-14
    assert found["angular momentum"] < 1e-14
    assert 1e-6 < found["energy"] < 0.02


def test_a_scheme_that_gains_energy_is_found_out() -> None:
    found = drifts(scene(scheme="euler"))
    assert found["energy"] > 0.02
    assert found["angular momentum"] > 1e-4
    assert found["momentum"] < 1e-14


@pytest.mark.parametrize(
    ("forces", "kept"),
    [
        ([{"type": "gravity"}], ["energy"]),
        ([{"type": "drag", "coefficient": 1}], []),
        ([{"type": "springs", "stiffness": 1, "pairs": [[0, 1]], "damping": 1}], ["momentum", "angular momentum"]),
        ([{"type": "soft_sphere", "diameter": 0.1, "stiffness": 1}], []),
    ],
)
def test_only_what_the_forces_keep_is_looked_at(forces: list[dict[str, object]], kept: list[str]) -> None:
    assert names(scene(*forces, scheme="rk4")) == kept


def test_of_particles_that_come_and_go_nothing_is_said() -> None:
    dying = {"stars": {**BODIES, "lifetime": 1}}
    assert names(scene(particles=dying)) == []
    assert names(scene(emitters={"sparks": {"rate": 1, "lifetime": 1}})) == []


def test_energy_is_looked_at_where_the_run_pays_for_it() -> None:
    runtime.start("double", 1)
    from particlecli.dynamics.system import System

    plan = make_plan(scene())
    simulation = cast(Simulation, SimpleNamespace(scene=plan.scene, plan=plan, system=System(plan)))
    assert Conserved(simulation, Besides(0.0)).names == ["momentum", "angular momentum"]
    paying = Conserved(simulation, Besides(10.0))
    assert paying.names == Conserved(simulation).names == ["energy", "momentum", "angular momentum"]
    assert 0.0 < paying.price < 0.05 * 10.0

"""Forces between particles are refused where they would be wrong in silence."""

import pytest

from particlecli.scene.checks import problems
from particlecli.scene.model import Scene

FLUID = {"type": "sph", "density": 1000, "smoothing": 0.1, "sound_speed": 20}


def found(**parts):
    scene = Scene.model_validate({"duration": 1, **parts})
    return {".".join(map(str, path)): message for path, message in problems(scene)}


@pytest.mark.parametrize(
    "parts",
    [
        {"emitters": {"water": {"rate": 10}}},
        {"particles": {"water": {"positions": [[0, 1, 0]], "lifetime": 1}}},
        {"particles": {"water": {"positions": [[0, 1, 0]]}}, "planes": [{"on_hit": "die"}]},
    ],
)
def test_continuity_needs_a_fluid_that_is_all_there(parts):
    assert "use summation" in found(**parts, forces=[FLUID])["forces.0.density_by"]
    assert "forces.0.density_by" not in found(**parts, forces=[{**FLUID, "density_by": "summation"}])


def test_a_fluid_that_stays_may_go_by_continuity():
    assert found(particles={"water": {"positions": [[0, 1, 0]]}}, forces=[FLUID], planes=[{}]) == {}


def test_a_fluid_meets_planes_at_rest_only():
    parts = {
        "particles": {"water": {"positions": [[0, 1, 0]]}, "dust": {"positions": [[1, 1, 0]]}},
        "frames": {"lift": {"translate": [0, "t", 0]}},
        "forces": [{**FLUID, "on": ["water"]}],
    }
    assert "at rest only" in found(**parts, planes=[{"frame": "lift"}])["planes.0.frame"]
    assert found(**parts, planes=[{"frame": "lift", "on": ["dust"]}]) == {}

"""On every shipped scene `auto` is as accurate as asked for, at no more than 1.5 times the least cost."""

import pytest

from particlecli.scene.integrator import Integrator
from tests.auto.shipped import ROOT, SHIPPED, judged, name_of


@pytest.mark.slow
@pytest.mark.parametrize("path", SHIPPED, ids=name_of)
def test_shipped_scenes_are_as_accurate_as_asked_for_at_hardly_more_than_the_least_cost(path):
    found = judged(path)
    assert found.followed >= 0.5
    assert found.accurate, found
    assert not found.cheaper, found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scheme", "dt", "accurate", "dear"),
    [
        pytest.param("midpoint", 1 / 120, False, False, id="steps too long"),
        pytest.param("rk4", 1 / 300, True, True, id="steps too short"),
    ],
)
def test_the_judge_tells_a_wrong_choice(scheme, dt, accurate, dear):
    found = judged(ROOT / "scenes" / "fire_whirl.yaml", Integrator(type=scheme, dt=dt))
    assert (found.accurate, bool(found.cheaper)) == (accurate, dear)

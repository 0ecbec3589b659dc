"""Children that cannot be are refused at their key."""

import pytest
from pydantic import ValidationError

from particlecli.scene.checks import problems
from particlecli.scene.groups import Children
from particlecli.scene.model import Scene

DEATH = {"on": "death", "emitter": "b", "count": 3}


def found(**emitters):
    scene = Scene.model_validate({"duration": 2, "emitters": emitters})
    return {".".join(map(str, path)): message for path, message in problems(scene)}


def test_children_need_no_rate_of_their_own():
    assert found(a={"rate": 1, "lifetime": 1, "children": DEATH}, b={}) == {}
    assert "nothing is ever born" in found(a={"rate": 1}, b={})["emitters.b"]


@pytest.mark.parametrize(
    ("emitters", "place", "words"),
    [
        ({"a": {"rate": 1, "lifetime": 1, "children": DEATH}}, "emitters.a.children.0.emitter", "no emitter"),
        ({"a": {"rate": 1, "children": DEATH}, "b": {}}, "emitters.a.children.0.on", "never die"),
        (
            {
                "a": {"rate": 1, "lifetime": 1, "children": DEATH},
                "b": {"lifetime": 1, "children": {**DEATH, "emitter": "a"}},
            },
            "emitters.a.children.0.emitter",
            '"a" bears "b" bears "a": it would breed without end',
        ),
        (
            {"b": {"rate": 1, "lifetime": 1, "children": DEATH}},
            "emitters.b.children.0.emitter",
            '"b" bears "b": it would breed without end',
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(emitters, place, words):
    assert words in found(**emitters).get(place, "")


def test_impacts_need_a_plane_and_its_instants():
    emitters = {"a": {"rate": 1, "children": {**DEATH, "on": "impact"}}, "b": {}}
    assert "bounce off" in found(**emitters)["emitters.a.children.0.on"]
    scene = {"duration": 2, "emitters": emitters, "planes": [{}]}
    assert problems(Scene.model_validate(scene)) == []
    simple = {**scene, "integrator": {"type": "rk4", "contact": "end_of_step"}}
    ((_, message),) = problems(Scene.model_validate(simple))
    assert "contact: located" in message


@pytest.mark.parametrize(
    "wrong",
    [{"on": "death", "rate": 3}, {"on": "death", "count": 3, "impacts": 2}, {"on": "way", "count": 3}, {"on": "way"}],
)
def test_deaths_have_counts_and_ways_have_rates(wrong):
    with pytest.raises(ValidationError):
        Children.model_validate({"emitter": "b", **wrong})

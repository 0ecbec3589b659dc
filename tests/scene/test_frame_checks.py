"""Coordinate frames that make no sense are refused at their key."""

import pytest

from particlecli.scene.checks import problems
from particlecli.scene.model import Scene

GROUP = {"a": {"positions": [[0, 0, 0]]}}


def found(**parts):
    parts.setdefault("particles", GROUP)
    return [
        (".".join(map(str, path)), message)
        for path, message in problems(Scene.model_validate({"duration": 2, **parts}))
    ]


FRAMES = {"base": {"rotate": {"axis": [0, 1, 0], "angle": "t"}}, "tip": {"parent": "base", "translate": [0, 1, 0]}}


def test_a_tree_of_frames_is_fine():
    emitters = {"sparks": {"frame": "tip", "rate": 3, "inherit_velocity": 0.5}}
    forces = [{"type": "point_gravity", "frame": "base", "strength": 1}]
    assert found(frames=FRAMES, emitters=emitters, forces=forces) == []


@pytest.mark.parametrize(
    ("parts", "place", "words"),
    [
        ({"frames": {"tip": {"parent": "bass"}, "base": {}}}, "frames.tip.parent", 'did you mean "base"'),
        ({"frames": {"a": {"parent": "b"}, "b": {"parent": "a"}}}, "frames.a.parent", "rides on itself"),
        ({"frames": {"a": {"parent": "a"}}}, "frames.a.parent", "rides on itself"),
        ({"frames": {"a": {"translate": [0, "1/(t - 1)", 0]}}}, "frames.a.translate.1", "not finite"),
        ({"frames": {"a": {"rotate": {"axis": [1, 0, 0], "angle": "log(-t)"}}}}, "frames.a.rotate.angle", "not finite"),
        ({"frames": {"a": {"scale": "1 - t"}}}, "frames.a.scale", "must be positive"),
        ({"emitters": {"s": {"rate": 1, "frame": "tap"}}, "frames": FRAMES}, "emitters.s.frame", '"tip"'),
        ({"particles": {"a": {"positions": [[0, 0, 0]], "frame": "x"}}}, "particles.a.frame", "no frame"),
        ({"forces": [{"type": "vortex", "swirl": 1, "frame": "x"}]}, "forces.0.frame", "no frame"),
        ({"emitters": {"s": {"rate": 1, "inherit_velocity": 0.5}}}, "emitters.s.inherit_velocity", "`frame`"),
        ({"emitters": {"s": {"rate": 1, "motion": "fixed"}}}, "emitters.s.motion", "what is born moves"),
        ({"particles": {"a": {"positions": [[0, 0, 0]], "motion": "fixed", "mass": 2}}}, "particles.a.mass", "fixed"),
        (
            {
                "particles": {"a": {"positions": [[0, 0, 0]], "motion": "fixed"}},
                "forces": [{"type": "gravity", "on": ["a"]}],
            },
            "forces.0.on.0",
            "its frame carries it",
        ),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused(parts, place, words):
    problem = next((message for path, message in found(**parts) if path == place), None)
    assert problem is not None
    assert words in problem

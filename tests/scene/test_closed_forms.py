"""Which scenes the exact integrator accepts, and what it says to the others."""

import numpy as np
import pytest

from particlecli.scene.checks import problems
from particlecli.scene.closed_forms import linear, principal_axes
from particlecli.scene.expression import Expression
from particlecli.scene.forces import ForceField
from particlecli.scene.model import Scene

WINDS = {
    "wind": [{"type": "uniform", "velocity": [1, 0, 0]}, {"type": "expression", "velocity": ["1", "2", "0"]}],
    "shear": [{"type": "expression", "velocity": ["y", "0", "0"]}],
}


def found(integrator=None, **parts):
    described = Scene.model_validate(
        {
            "duration": 1,
            "fps": 10,
            "flows": WINDS,
            "particles": {"a": {"positions": [[0, 0, 0]]}},
            "integrator": {"type": "exact", **(integrator or {})},
            **parts,
        }
    )
    return [message for path, message in problems(described) if path[0] == "integrator"]


def field(**parts):
    return {"type": "force_field", **parts}


ACCEPTED = [
    [{"type": "gravity"}, {"type": "drag", "coefficient": 1, "flow": "wind"}],
    [field(potential="50*(x - 1)**2 + y**2 - z**2")],
    [field(potential="(x - y)**2")],
    [field(force=["-4*(x - 2) - 0.3*u", "-y/0.1", "min(z, z)"])],
    [],
]


@pytest.mark.parametrize("forces", ACCEPTED, ids=str)
def test_linear_forces_are_accepted(forces):
    assert found(forces=forces) == []


REFUSED = [
    ({"type": "quadratic_drag", "coefficient": 1}, "the quadratic_drag of forces[1] has none"),
    ({"type": "point_gravity", "strength": 1}, "the point_gravity of forces[1] has none"),
    ({"type": "drag", "coefficient": 1, "flow": "shear"}, 'the flow "shear" of the drag of forces[1] is not uniform'),
    (field(potential="x**4"), "the force_field of forces[1] is not linear"),
    (field(force=["sin(t)", "0", "0"]), "the force_field of forces[1] is not linear"),
    (field(force=["floor(x)", "0", "0"]), "the force_field of forces[1] is not linear"),
    (field(force=["x > 0", "0", "0"]), "the force_field of forces[1] is not linear"),
    (field(potential="where(x < 0, x, -x)"), "the force_field of forces[1] is not linear"),
    (field(force=["v", "-u", "0"]), "act along three fixed axes"),
]


@pytest.mark.parametrize(("force", "said"), REFUSED, ids=str)
def test_a_force_without_a_closed_form_is_refused_by_name(force, said):
    (message,) = found(forces=[{"type": "gravity"}, force])
    assert said in message
    assert "use rk4 or dormand_prince, or radau_iia" in message
    assert found({"type": "rk4"}, forces=[{"type": "gravity"}, force]) == []


def test_forces_on_no_newtonian_group_do_not_matter():
    groups = {"a": {"positions": [[0, 0, 0]], "motion": "first_order", "flow": "wind"}}
    assert found(particles=groups, forces=[{"type": "point_gravity", "strength": 1}]) == []


def test_a_group_must_be_carried_by_a_uniform_flow():
    def carried(flow):
        return found(particles={"a": {"positions": [[0, 0, 0]], "motion": "first_order", "flow": flow}})

    assert carried("wind") == []
    assert 'the flow "shear", which carries "a", is not uniform' in carried("shear")[0]


@pytest.mark.parametrize(
    ("plane", "forces", "said"),
    [
        ({"friction": 0.3}, [{"type": "gravity"}], "sliding with the friction of planes[0]"),
        ({"normal": [1, 1, 0]}, [field(potential="x**2")], "do not act along its normal"),
        ({"normal": [1, 1, 0]}, [{"type": "drag", "coefficient": 1}], None),
        ({"normal": [1, 1, 0], "on_hit": "die"}, [field(potential="x**2")], None),
        ({}, [field(potential="x**2")], None),
    ],
)
def test_planes_that_break_the_closed_form_are_refused(plane, forces, said):
    messages = found(planes=[plane], forces=forces)
    assert (said is None) == (messages == [])
    assert said is None or said in messages[0]
    assert found({"contact": "end_of_step"}, planes=[plane], forces=forces) == []


def test_principal_axes_diagonalize_both_matrices():
    spec = ForceField.model_validate(field(force=["-2*x + y - 0.3*u", "x - 2*y - 0.3*v", "-5*z - w"]))
    part = linear(spec)
    axes = principal_axes([part])
    for matrix in part:
        turned = axes.T @ matrix @ axes
        np.testing.assert_allclose(turned, np.diag(np.diag(turned)), atol=1e-14)


@pytest.mark.parametrize(
    ("formula", "continuous"),
    [("x**2 + sin(x)", True), ("abs(x)", True), ("floor(x)", False), ("x % 2", False), ("2*(x > 0)", False)],
)
def test_expressions_know_whether_they_may_jump(formula, continuous):
    assert Expression(formula).continuous == continuous

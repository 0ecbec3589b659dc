"""Forces that ride on coordinate frames, against the forces themselves seen from the moving frame."""

import numpy as np
import pytest
from pydantic import TypeAdapter
from scipy.spatial.transform import Rotation

from particlecli.dynamics.forces import force_term
from particlecli.scene.forces import Force
from particlecli.scene.frames import CoordinateFrame
from tests.dynamics.harness import on_packs

FRAMES = {
    "cart": CoordinateFrame.model_validate({"translate": ["2*t", 0.5, 0], "scale": "1 + t"}),
    "arm": CoordinateFrame.model_validate(
        {"parent": "cart", "translate": [0, 1, 0], "rotate": {"axis": [0, 0.6, 0.8], "angle": "3*t"}}
    ),
}
AXIS = np.array([0.0, 0.6, 0.8])
SPECS = [
    {"type": "point_gravity", "center": [0.3, 0.2, -0.1], "strength": 2.0, "softening": 0.3},
    {"type": "vortex", "center": [0.3, 0.2, -0.1], "axis": [1, 0, 0], "swirl": 1.5, "pull": 0.5},
    {"type": "orbit", "center": [0.3, 0, -0.1], "strength": 1.2, "exponent": 2},
]


def force(spec, **more):
    return TypeAdapter(Force).validate_python({**spec, **more})


@pytest.fixture(scope="module", params=SPECS, ids=lambda spec: spec["type"])
def terms(request):
    return force_term(force(request.param)), force_term(force(request.param, frame="arm"), FRAMES)


def evaluated(term, x, t, what="acceleration"):
    """Acceleration (3, n) or its derivative by position (9, n) of a force without velocity."""
    zeros = (0.0, 0.0, 0.0)

    def function(p, *packs):
        if what == "acceleration":
            return term.acceleration(p, packs[:3], zeros, zeros, packs[3], 1.0)
        by_position, _ = term.jacobian(p, packs[:3], zeros, zeros, None, packs[3], 1.0)
        return [entry for row in by_position for entry in row]

    outputs = 3 if what == "acceleration" else 9
    return on_packs("double", function, *x, t, outputs=outputs, parameters=term.parameters(), one_by_one=True)


def test_the_force_is_that_of_the_moved_center(terms):
    still, riding = terms
    generator = np.random.default_rng(6)
    x, t = generator.normal(size=(3, 16)), generator.uniform(0, 2, 16)
    turns = Rotation.from_rotvec(3 * t[:, None] * AXIS)
    center = np.asarray(still.spec.center)
    middle = np.stack([2 * t, 0.5 + 0 * t, 0 * t], axis=1) + (1 + t)[:, None] * (
        np.array([0.0, 1.0, 0.0]) + turns.apply(center)
    )
    seen = center + turns.inv().apply(x.T - middle)
    right = turns.apply(evaluated(still, seen.T, t).T).T
    np.testing.assert_allclose(evaluated(riding, x, t), right, rtol=1e-11, atol=1e-12)


def test_the_jacobian_is_the_slope_of_the_acceleration(terms):
    _, riding = terms
    generator = np.random.default_rng(7)
    x, t = generator.normal(size=(3, 16)), generator.uniform(0, 2, 16)
    h = 1e-4
    slopes = [
        (evaluated(riding, x + h * way[:, None], t) - evaluated(riding, x - h * way[:, None], t)) / (2 * h)
        for way in np.eye(3)
    ]
    right = np.stack(slopes, axis=1).reshape(9, -1)
    size = np.abs(right).max()
    np.testing.assert_allclose(evaluated(riding, x, t, "jacobian"), right, rtol=0, atol=1e-5 * size)

"""Particles that are born of others are carried again with their parents."""

import numpy as np

from particlecli.simulate import Simulation
from tests.accuracy.test_estimate import WITHIN, estimated
from tests.dynamics.scenes import scene

SHELLS = {
    "duration": 2,
    "fps": 10,
    "emitters": {
        "shells": {
            "rate": 30,
            "direction": {"spread": 40},
            "speed": {"uniform": [5, 9]},
            "lifetime": {"uniform": [0.4, 0.9]},
            "children": [
                {"on": "death", "emitter": "stars", "count": 6, "inherit_velocity": 0.5},
                {"on": "way", "emitter": "trail", "rate": 9},
            ],
        },
        "stars": {
            "direction": {"spread": 180},
            "speed": 3,
            "children": {"on": "way", "emitter": "dust", "rate": 3},
        },
        "trail": {"speed": 0},
        "dust": {"speed": 0, "lifetime": 0.5},
    },
    "forces": [{"type": "gravity"}, {"type": "quadratic_drag", "coefficient": 0.3}],
}


def test_children_are_carried_again_with_their_parents():
    errors, frames, simulation = estimated(scene(**SHELLS, integrator={"type": "euler", "dt": 0.02}))
    again = simulation.system.frame(len(frames) - 1)
    for name, group in again.groups.items():
        np.testing.assert_array_equal(group.ids, frames[-1].groups[name].ids)
        np.testing.assert_array_equal(group.positions, frames[-1].groups[name].positions)
    exact = list(Simulation(scene(**SHELLS, integrator={"type": "rk4", "dt": 0.002}, precision="double"), threads=1))
    for name in ("shells", "stars", "trail", "dust"):
        apart = []
        for run, best in zip(frames[1:], exact[1:], strict=True):
            found, true = run.groups[name], best.groups[name]
            _, here, there = np.intersect1d(found.ids, true.ids, return_indices=True)
            apart.append(np.linalg.norm(found.positions[here] - true.positions[there], axis=1))
        true = np.quantile(np.concatenate(apart), 0.95)
        assert true / WITHIN < errors[name].metres.p95 < WITHIN * true, name
        assert 0 < errors[name].sampled < simulation.births[name]
    assert errors["stars"].trend == "unchecked"

"""Poses of coordinate frames, and particles that are born on them, against homogeneous matrices written apart."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from particlecli import simulate
from particlecli.dynamics.births import EmitterBirths, ParticleBirths
from particlecli.dynamics.fixed import FixedGroup
from particlecli.scene.frames import chain
from particlecli.scene.poses import Poses, planes_at
from tests.dynamics.scenes import scene

FRAMES = {
    "base": {"rotate": {"axis": [0, 1, 0], "angle": "0.5*t"}},
    "shoulder": {
        "parent": "base",
        "translate": [0, "1 + 0.1*t**2", 0],
        "rotate": {"axis": [1, 2, 2], "angle": "0.6*sin(20*t)"},
        "scale": "1 + 0.5*t",
    },
    "tip": {"parent": "shoulder", "translate": [0, 0.8, 0]},
}


def moved(axis, angle, shift, scale=1.0):
    """A pose as a 4×4 matrix."""
    matrix = np.eye(4)
    unit = np.array(axis) / np.linalg.norm(axis)
    matrix[:3, :3] = scale * Rotation.from_rotvec(angle * unit).as_matrix()
    matrix[:3, 3] = shift
    return matrix


def tip(t):
    """The matrix of the frame `tip` at a time."""
    base = moved([0, 1, 0], 0.5 * t, [0, 0, 0])
    shoulder = moved([1, 2, 2], 0.6 * np.sin(20 * t), [0, 1 + 0.1 * t**2, 0], 1 + 0.5 * t)
    return base @ shoulder @ moved([0, 1, 0], 0.0, [0, 0.8, 0])


def at(t, local):
    return (tip(t) @ [*local, 1.0])[:3]


TIMES = np.linspace(0.0, 3.0, 61)


@pytest.fixture(scope="module")
def poses():
    return Poses.of(chain(scene(frames=FRAMES, particles={"a": {"positions": [[0, 0, 0]]}}).frames, "tip"), TIMES)


def test_points_go_through_the_whole_chain(poses):
    local = np.random.default_rng(3).normal(size=(3, len(TIMES)))
    right = np.stack([at(t, point) for t, point in zip(TIMES, local.T, strict=True)], axis=1)
    np.testing.assert_allclose(poses.points(local), right, rtol=0, atol=1e-13)


def test_velocities_are_the_slope_of_the_path(poses):
    local = np.random.default_rng(4).normal(size=(3, len(TIMES)))
    h = 1e-4
    right = [(8 * (at(t + h, p) - at(t - h, p)) - (at(t + 2 * h, p) - at(t - 2 * h, p))) / (12 * h)
             for t, p in zip(TIMES, local.T, strict=True)]  # fmt: skip
    np.testing.assert_allclose(poses.velocities(local).T, right, rtol=0, atol=1e-8)


def test_directions_turn_and_keep_their_length(poses):
    local = np.random.default_rng(5).normal(size=(3, len(TIMES)))
    turned = poses.directions(local)
    np.testing.assert_allclose(np.linalg.norm(turned, axis=0), np.linalg.norm(local, axis=0), rtol=1e-14)
    right = [tip(t)[:3, :3] @ vector / (1 + 0.5 * t) for t, vector in zip(TIMES, local.T, strict=True)]
    np.testing.assert_allclose(turned.T, right, rtol=0, atol=1e-14)


def test_planes_stand_where_their_frame_has_taken_them():
    planes = [{"point": [0.1, 0.2, 0.3], "normal": [3, 4, 0], "frame": "tip"}, {"normal": [0, 0, 1]}]
    made = scene(frames=FRAMES, particles={"a": {"positions": [[0, 0, 0]]}}, planes=planes)
    carried, still = planes_at(made.planes, made.frames, 1.7)
    np.testing.assert_allclose(carried.point, at(1.7, [0.1, 0.2, 0.3]), rtol=0, atol=1e-13)
    turned = tip(1.7)[:3, :3] @ [0.6, 0.8, 0.0] / (1 + 0.5 * 1.7)
    np.testing.assert_allclose(carried.normal, turned, rtol=0, atol=1e-14)
    assert still is made.planes[1]


def riding(**emitter):
    """Births of an emitter on the tip."""
    given = {"frame": "tip", "rate": 400, "speed": 2, "direction": {"axis": [1, 0, 0]}, **emitter}
    made = scene(frames=FRAMES, emitters={"sparks": given}, duration=3)
    return EmitterBirths(made.seed, "sparks", made.emitters["sparks"], made.duration, chain(made.frames, "tip"))


def test_births_are_at_the_tip_at_their_instants_with_its_velocity():
    for share in (0.0, 0.5, 1.0):
        births = riding(inherit_velocity=share)
        table = births.table(0, births.total)
        h = 1e-4
        for place in range(0, births.total, 97):
            t = table.times[place]
            np.testing.assert_allclose(table.positions[:, place], at(t, [0, 0, 0]), rtol=0, atol=1e-12)
            own = tip(t)[:3, 0] / (1 + 0.5 * t) * 2
            swept = 8 * (at(t + h, [0] * 3) - at(t - h, [0] * 3)) - (at(t + 2 * h, [0] * 3) - at(t - 2 * h, [0] * 3))
            right = own + share * swept / (12 * h)
            np.testing.assert_allclose(table.velocities[:, place], right, rtol=0, atol=1e-8)


def test_a_fast_tip_leaves_no_clumps():
    """Births of a constant rate lie as far apart along the path as the tip moves between them."""
    births = riding()
    table = births.table(0, births.total)
    steps = np.linalg.norm(np.diff(table.positions, axis=1), axis=0)
    middles = 0.5 * (table.times[1:] + table.times[:-1])
    h = 1e-5
    speeds = np.array([np.linalg.norm(at(t + h, [0] * 3) - at(t - h, [0] * 3)) / (2 * h) for t in middles])
    np.testing.assert_allclose(steps, speeds * np.diff(table.times), rtol=2e-2, atol=1e-5)


@pytest.mark.parametrize(("fps", "dt"), [(7, 0.1), (100, 0.003)])
def test_births_depend_neither_on_step_nor_on_frame_rate(fps, dt):
    """In a simulation without forces every particle lies on the straight line from its birth."""
    births = riding()
    table = births.table(0, births.total)
    made = scene(
        frames=FRAMES,
        emitters={"sparks": {"frame": "tip", "rate": 400, "speed": 2, "direction": {"axis": [1, 0, 0]}}},
        duration=3,
        fps=fps,
        precision="double",
        integrator={"type": "euler", "dt": dt},
    )
    last = list(simulate(made))[-1]
    flown = last.time - table.times
    np.testing.assert_allclose(
        last.groups["sparks"].positions.T, table.positions + table.velocities * flown, rtol=0, atol=1e-12
    )


def test_particles_begin_in_their_frame_with_its_velocity():
    made = scene(
        frames={"wheel": {"translate": [1, 0, 0], "rotate": {"axis": [0, 0, 1], "angle": "2 + 3*t"}}},
        particles={"rim": {"positions": [[0.5, 0, 0]], "velocities": [[1, 0, 0]], "frame": "wheel"}},
    )
    table = ParticleBirths(made, "rim").table(0, 1)
    out = np.array([np.cos(2), np.sin(2), 0])
    along = np.array([-np.sin(2), np.cos(2), 0])
    np.testing.assert_allclose(table.positions[:, 0], np.array([1, 0, 0]) + 0.5 * out, rtol=0, atol=1e-15)
    np.testing.assert_allclose(table.velocities[:, 0], out + 1.5 * along, rtol=0, atol=1e-15)


def test_a_fixed_group_moves_with_its_frame_alone():
    made = scene(
        frames=FRAMES,
        particles={
            "arm": {"positions": [[0, 0, 0], [0, 0.8, 0]], "motion": "fixed", "frame": "tip", "temperature": 900}
        },
        precision="double",
    )  # fmt: skip
    arm = FixedGroup(made, "arm").frame(1.7, frozenset({"velocities", "ages", "temperatures"}))
    np.testing.assert_allclose(arm.positions, [at(1.7, [0, 0, 0]), at(1.7, [0, 0.8, 0])], rtol=0, atol=1e-14)
    h = 1e-6
    right = [(at(1.7 + h, p) - at(1.7 - h, p)) / (2 * h) for p in ([0, 0, 0], [0, 0.8, 0])]
    np.testing.assert_allclose(arm.velocities, right, rtol=0, atol=1e-7)
    assert arm.ages.tolist() == [1.7, 1.7]
    assert arm.temperatures.tolist() == [900, 900]
    frames = list(simulate(made))
    np.testing.assert_allclose(frames[-1].groups["arm"].positions[0], at(1.0, [0, 0, 0]), rtol=0, atol=1e-14)
    assert frames[0].alive == 2

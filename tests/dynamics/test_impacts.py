"""Impacts located in time: instants, order, corners, rest and friction, against closed forms and hard cases."""

import math

import numpy as np
import pytest

from tests.cases import later
from tests.dynamics.scenes import body, system

G = 9.81
DOWN = {"type": "gravity", "acceleration": [0, -G, 0]}
BALL = {"particles": {"a": body((0, 1, 0), (0, 0, 0))}, "forces": [DOWN]}


def made(scheme="rk4", dt=0.01, **parts):
    return system(precision="double", integrator={"type": scheme, "dt": dt}, **parts)


def ball(restitution, **more):
    return made(**{**BALL, "planes": [{"restitution": restitution}], **more})


def advanced(scene, until, frames=10):
    for frame in range(1, frames + 1):
        scene.advance(until * frame / frames)
    return scene.get_state()


def bounced(t, restitution, height=1.0):
    """Height of a ball dropped from rest at time t, in closed form."""
    fall = math.sqrt(2 * height / G)
    if t <= fall:
        return height - G * t * t / 2
    t -= fall
    speed = restitution * G * fall
    while speed > 1e-12:
        if t <= 2 * speed / G:
            return speed * t - G * t * t / 2
        t -= 2 * speed / G
        speed *= restitution
    return 0.0


@pytest.mark.parametrize("restitution", [1.0, 0.5])
@pytest.mark.parametrize("until", [*later(0.7, 1.0), 1.3])
def test_dropped_ball_is_where_the_closed_form_says(restitution, until):
    state = advanced(ball(restitution), until)
    assert state[1] == pytest.approx(bounced(until, restitution), abs=1e-11)


def test_dropped_ball_comes_to_rest_at_its_instant():
    rest = math.sqrt(2 / G) * 1.5 / 0.5
    scene = ball(0.5)
    before = advanced(scene, rest - 1e-9)
    assert before[4] != 0.0
    scene.advance(rest + 1e-9)
    np.testing.assert_array_equal(scene.get_state(), 0.0)


def test_a_bouncy_ball_goes_on_sliding_where_its_bouncing_ends():
    """Its last bounces are too quick to be told apart; they end in rest on the plane, not along it."""
    end = advanced(ball(0.95, particles={"a": body((0, 1e-3, 0), (1, 0, 0))}), 2.0)
    np.testing.assert_allclose(end, [2, 0, 0, 1, 0, 0], rtol=0, atol=1e-12)


def order_through_bounces(scheme):
    """Of a body on an oscillator's orbit that hits a wall twice at an angle; its exact way is known."""
    steps = {
        1: (400, 800, 1600, 3200),
        2: (50, 100, 200, 400),
        3: (50, 100, 200, 400),
        4: (30, 60, 120, 240),
        5: (20, 40, 60, 80),
    }
    from particlecli.dynamics.integrators import SCHEMES

    scene = made(
        scheme,
        particles={"a": body((1.0, 0.5, 0), (0.0, 0.7, 0))},
        forces=[{"type": "force_field", "force": ["-x", "-y", 0]}],
        planes=[{"point": [-0.4, 0, 0], "normal": [1, 0, 0], "restitution": 0.8}],
    )
    start = scene.get_state()
    errors = []
    counts = steps[SCHEMES[scheme].order]
    for count in counts:
        scene.set_state(start)
        scene.groups["a"].advance(0.0, 5.0, count)
        errors.append(np.abs(scene.get_state()[:2] - oscillator_with_wall(5.0)).max())
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0]


def oscillator_with_wall(until):
    x, v, t = 1.0, 0.0, 0.0
    amplitude, phase = math.hypot(x, v), math.atan2(-v, x)
    while True:
        hit = math.acos(-0.4 / amplitude) - phase
        while hit <= 1e-12:
            hit += 2 * math.pi
        if t + hit > until:
            break
        t += hit
        x, v = -0.4, 0.8 * amplitude * math.sin(hit + phase)
        amplitude, phase = math.hypot(x, v), math.atan2(-v, x)
    y = 0.5 * math.cos(until) + 0.7 * math.sin(until)
    return np.array([amplitude * math.cos(until - t + phase), y])


@pytest.mark.parametrize(
    ("scheme", "order"),
    [
        ("velocity_verlet", 2),
        ("rk4", 4),
        *later(
            ("euler", 1),
            ("symplectic_euler", 1),
            ("implicit_euler", 1),
            ("midpoint", 2),
            ("implicit_midpoint", 2),
            ("trapezoidal", 2),
            ("tr_bdf2", 2),
            ("rk3", 3),
            ("yoshida4", 4),
            ("radau_iia", 5),
        ),
    ],
)
def test_schemes_keep_their_order_through_bounces(scheme, order):
    assert order_through_bounces(scheme) == pytest.approx(order, abs=0.2)


def test_nothing_goes_through_at_a_thousand_metres_a_second():
    scene = made(
        dt=0.1,
        particles={"a": body((0, 30, 0), (0, -1000.0, 0))},
        planes=[{"restitution": 0.9}],
        forces=[DOWN],
    )
    state = advanced(scene, 1.0)
    fall = (-1000 + math.sqrt(1000**2 + 2 * G * 30)) / G
    speed = 0.9 * (1000 + G * fall)
    left = 1.0 - fall
    np.testing.assert_allclose(state[[1, 4]], [speed * left - G * left**2 / 2, speed - G * left], rtol=1e-12)


def test_many_impacts_in_one_step_between_two_planes_a_millimetre_apart():
    scene = made(
        dt=0.1,
        particles={"a": body((0, 2e-4, 0), (3.0, 1.0, 0))},
        planes=[{"restitution": 1.0}, {"point": [0, 1e-3, 0], "normal": [0, -1, 0], "restitution": 1.0}],
    )
    state = advanced(scene, 1.0)
    way = (1.0 + 2e-4) % 2e-3
    assert state[0] == pytest.approx(3.0)
    assert state[1] == pytest.approx(min(way, 2e-3 - way), abs=1e-9)
    assert abs(state[4]) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("restitution", [0.5, *later(0.0, 1.0)])
def test_corner_of_three_planes_holds(restitution):
    planes = [{"normal": normal, "restitution": restitution} for normal in ([1, 0, 0], [0, 1, 0], [0.3, 0.2, 1])]
    scene = made(
        dt=0.02,
        particles={
            "a": {"layout": {"type": "ball", "center": [1, 1, 1], "radius": 0.4, "count": 50}, "velocity": [-3, -4, -5]}
        },
        forces=[{"type": "gravity", "acceleration": [-5, -5, -5]}],
        planes=planes,
    )
    state = advanced(scene, 5.0).reshape(6, 50)
    for normal in ([1, 0, 0], [0, 1, 0], [0.3, 0.2, 1]):
        assert np.all(np.array(normal) @ state[:3] > -1e-9)
    if restitution < 1:
        np.testing.assert_allclose(state, 0.0, atol=1e-6)


@pytest.mark.slow
def test_incline_above_the_friction_angle_does_not_creep():
    normal = (math.sin(math.pi / 6), math.cos(math.pi / 6), 0.0)
    scene = made(
        particles={"a": body((0, 0, 0), (0, 0, 0))}, forces=[DOWN], planes=[{"normal": normal, "friction": 0.6}]
    )
    scene.groups["a"].advance(0.0, 1000.0, 100_000)
    assert np.abs(scene.get_state()).max() < 1e-12


def test_incline_below_the_friction_angle_slides_as_the_closed_form_says():
    normal = (math.sin(math.pi / 6), math.cos(math.pi / 6), 0.0)
    scene = made(
        particles={"a": body((0, 0, 0), (0, 0, 0))}, forces=[DOWN], planes=[{"normal": normal, "friction": 0.2}]
    )
    state = advanced(scene, 1.0)
    assert np.linalg.norm(state[:3]) == pytest.approx(0.5 * 3.205858157774931, rel=1e-12)


def test_flat_slide_stops_exactly():
    scene = made(
        particles={"a": body((0, 0, 0), (5.0, 0, 0))}, forces=[DOWN], planes=[{"friction": 0.3, "restitution": 0}]
    )
    state = advanced(scene, 1.698946653075093 - 1e-7, frames=17)
    assert state[3] == pytest.approx(0.3 * G * 1e-7, rel=1e-4)
    scene.advance(2.0)
    np.testing.assert_allclose(scene.get_state(), [4.247366632687734, 0, 0, 0, 0, 0], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("scheme", ["dormand_prince", *later("dop853")])
def test_adaptive_schemes_locate_impacts_too(scheme):
    scene = system(
        precision="double",
        integrator={"type": scheme, "tolerance": 1e-10},
        planes=[{"restitution": 0.5}],
        **BALL,
    )
    assert advanced(scene, 1.0)[1] == pytest.approx(bounced(1.0, 0.5), abs=1e-11)


def test_single_precision_meets_planes_far_from_the_origin():
    scene = system(
        integrator={"type": "rk4", "dt": 0.01},
        particles={"a": {**body((0, 1001.0, 0), (0, 0, 0))}},
        forces=[DOWN],
        planes=[{"point": [0, 1000, 0], "restitution": 0.5}],
    )
    state = advanced(scene, 3.0, frames=30)
    assert state[1] == pytest.approx(1000.0, abs=5e-4)
    assert abs(state[4]) < 0.05


WIND = {"type": "force_field", "force": ["0", "100", "0"]}
"""Blows a particle up again before it has gone through a step."""


def blown(height, restitution, t):
    """Height and speed after a time in the wind, 5 m/s down at first, in closed form."""
    speed = -5.0
    depth = 25.0 - 200.0 * height
    if depth > 0:
        hit = (5.0 - math.sqrt(depth)) / 100.0
        height, speed, t = 0.0, restitution * math.sqrt(depth), t - hit
    return height + speed * t + 50.0 * t * t, speed + 100.0 * t


@pytest.mark.parametrize("scheme", ["rk4", "dormand_prince", *later("velocity_verlet")])
def test_a_dip_through_a_plane_and_back_within_a_step_is_an_impact(scheme):
    heights = [0.02, 0.1, 0.12, 0.126, 0.2]
    particles = {"a": {"positions": [[x, h, 0] for x, h in enumerate(heights)], "velocities": [[0, -5, 0]] * 5}}
    scene = made(scheme, 0.1, particles=particles, forces=[WIND], planes=[{"restitution": 0.5}])
    scene.advance(0.1)
    found = scene.get_state().reshape(6, -1)
    expected = np.array([blown(height, 0.5, 0.1) for height in heights]).T
    np.testing.assert_allclose(found[[1, 4]], expected, atol=1e-9)

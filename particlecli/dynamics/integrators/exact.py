"""Steps by the closed form of x″ = A x + B x′ + c with constant A and B, along axes that do not disturb each other."""

import math

import taichi as ti

from particlecli.dynamics.algebra import add, bound, dot, mul
from particlecli.dynamics.matrices import is_zero, same
from particlecli.dynamics.vector_math import cos, exp, is_double, mean_decay, polynomial, sin
from particlecli.scene.closed_forms import linear, principal_axes

TINY = 1e-30
"""Keeps quotients of vanishing numbers finite."""

TERMS = {False: 12, True: 19}
"""Terms of the power series that reach single and double precision."""

AT_REST = [0.0, 0.0, 0.0]


@ti.data_oriented
class ExactStepper:
    """One step by the closed form, of any length.

    Along each axis, with κ and δ the derivatives of the acceleration by position and velocity and b the acceleration
    of a particle that rests where the step begins:

    x += S v + Q b, v ← S′ v + S b, with S″ = κ S + δ S′, S(0) = 0, S′(0) = 1 and Q = ∫ S.

    In terms of the roots r, R of ρ² = δh ρ + κh², S = h e[r, R] and Q = h² e[0, r, R] are divided differences of the
    exponential function, and so are real or complex roots, near or far apart or near zero, all alike.

    Args:
        motion: the equations of motion.
    """

    def __init__(self, motion) -> None:
        self.motion = motion
        # What lies on a plane stays at rest across it by `rest` alone: planes lie along the axes, see `closed_forms`.
        self.free = motion.free
        found = [linear(term.spec) for term in self.free.forces]
        parts = [part for part in found if part is not None]
        axes = principal_axes(parts) if len(parts) == len(found) else None
        if axes is None:
            raise ValueError("the forces have no closed form")
        self.axes = axes.T.tolist()

    @ti.func
    def step(self, p, state, t, h, body):
        """The state after a step of length h from time t."""
        rest = self.motion.derivative(p, state[:3] + AT_REST, t, body)
        if ti.static(self.motion.first_order):
            return [bound(add(state[c], mul(h, rest[c]))) for c in ti.static(range(3))] + state[3:]
        by_position, by_velocity = self.free.jacobian(p, state, t, body[:1])
        return ti.static(self._moved(state, h, rest[3:], by_position, by_velocity))

    def _moved(self, state, h, rest, by_position, by_velocity):
        known = {}
        gained = [[], []]
        for axis in self.axes:
            kappa, delta = (_along(axis, matrix) for matrix in (by_position, by_velocity))
            key = (same(kappa), same(delta))
            if key not in known:
                known[key] = propagator(h, kappa, delta)
            keep, reach, push = known[key]
            v, b = bound(dot(axis, state[3:])), bound(dot(axis, rest))
            gained[0].append(bound(add(mul(reach, v), mul(push, b))))
            gained[1].append(bound(add(mul(keep, v), mul(reach, b))))
        columns = list(zip(*self.axes, strict=True))
        x = [bound(add(state[c], dot(columns[c], gained[0]))) for c in range(3)]
        return x + [dot(columns[c], gained[1]) for c in range(3)]


def _along(axis, matrix):
    """The diagonal entry of a matrix along an axis."""
    return dot(axis, [dot(row, axis) for row in matrix])


def propagator(h, kappa, delta):
    """S′, S and Q of `ExactStepper`, as far as structural zeros do not make them simpler."""
    if is_zero(kappa) and is_zero(delta):
        return 1.0, h, bound(0.5 * h * h)
    if is_zero(kappa):
        return _damped(h, delta)
    return _swinging(h, kappa, delta)


@ti.func
def _damped(h, delta):
    """Where κ is zero."""
    r = delta * h
    mean = mean_growth(r)
    second = ti.select(ti.abs(r) < 1.0, _series(r, 0.0), (mean - 1.0) / r)
    return exp(r), h * mean, h * h * second


@ti.func
def _swinging(h, kappa, delta):
    k, s = kappa * h * h, 0.5 * delta * h
    discriminant = s * s + k
    # Real roots: the larger one first, as the other follows from it without cancellation.
    w = ti.sqrt(ti.max(discriminant, 0.0))
    larger = ti.select(s > 0.0, s + w, s - w)
    smaller = -k / ti.select(larger == 0.0, 1.0, larger)
    real_mean = exp(ti.max(larger, smaller)) * mean_decay(2.0 * w)
    real_keep = exp(larger) + smaller * real_mean
    real_second = (real_mean - mean_growth(smaller)) / larger
    # Complex roots s ± i angle.
    angle = ti.sqrt(ti.max(-discriminant, TINY))
    size = exp(s)
    complex_mean = size * sin(angle) / angle
    complex_keep = size * cos(angle) + s * complex_mean
    complex_second = (complex_keep - 2.0 * s * complex_mean - 1.0) / k
    swings = discriminant < 0.0
    near_zero = ti.select(swings, ti.abs(k), ti.abs(larger)) < 1.0
    second = ti.select(swings, complex_second, real_second)
    second = ti.select(near_zero, _series(2.0 * s, k), second)
    return (
        ti.select(swings, complex_keep, real_keep),
        h * ti.select(swings, complex_mean, real_mean),
        h * h * second,
    )


def mean_growth(r):
    """(exp r − 1)/r without cancellation."""
    return bound(exp(ti.max(r, 0.0)) * mean_decay(ti.abs(r)))


def _series(total, product):
    """e[0, r, R] = Σ h_n(r, R) / (n + 2)! for roots within 1, with h_n = (r + R) h_(n−1) − r R h_(n−2).

    Args:
        total: r + R.
        product: −r R.
    """
    terms = TERMS[is_double(total)]
    if is_zero(product):
        weights = [1 / math.factorial(n + 2) for n in range(terms)]
        return polynomial(total, weights, weights)
    before, last = 1.0, bound(total)
    found = bound(0.5 + total / 6.0)
    for n in range(2, terms):
        before, last = last, bound(add(mul(total, last), mul(product, before)))
        found = bound(found + last * (1 / math.factorial(n + 2)))
    return found

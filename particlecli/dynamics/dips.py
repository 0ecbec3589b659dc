"""Paths that dip through a plane and back within one step: seen from heights and speeds at its ends."""

import taichi as ti

from particlecli.dynamics.contacts import TINY


def may_dip(before, falling, after, rising, h):
    """Whether a path above a plane at both ends of a step may go below it between.

    A path that is bent away from the plane stays above its tangents at the ends, which meet below the plane only if
    this is true. Heights in m, their rates of change in m/s, h in s.
    """
    return (falling < 0.0) & (rising > 0.0) & (falling * after - rising * before - falling * rising * h > 0.0)


@ti.func
def lowest_at(before, falling, after, rising, h):
    """When a cubic that falls, then rises is lowest, s, by its heights and rates of change at the ends of a step."""
    gained = after - before
    a, b, c = (
        3.0 * (h * (falling + rising) - 2.0 * gained),
        2.0 * (3.0 * gained - h * (2.0 * falling + rising)),
        h * falling,
    )
    root = ti.sqrt(ti.max(b * b - 4.0 * a * c, 0.0))
    return -2.0 * c / (b + root + TINY) * h

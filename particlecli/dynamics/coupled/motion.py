"""The equations of motion of all coupled particles: what acts on each alone, and what they exert on each other."""

from collections.abc import Sequence
from itertools import accumulate, chain
from typing import Any

import numpy as np
import taichi as ti

from particlecli.dynamics.algebra import add, bound, mul
from particlecli.dynamics.coupled.base import CoupledTerm
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.group import Group
from particlecli.dynamics.group_plan import Constant

NOISE = 1e-5
"""Parts of a product of a block's entries that may be rounding."""


@ti.data_oriented
class CoupledMotion:
    """Accelerations of the particles of `points`, pack by pack.

    Args:
        groups: the coupled groups, in the order of `points.names`.
        terms: the forces between particles.
        points: all particles, at the stage at which accelerations are asked for.
    """

    def __init__(self, groups: Sequence[Group], terms: Sequence[CoupledTerm[Any]], points: Points) -> None:
        self.groups = list(groups)
        self.terms = list(terms)
        self.points = points
        lists = [term.parameters() for term in terms]
        ends = list(accumulate(len(values) for values in lists))
        self.spans = [(end - len(values), end) for end, values in zip(ends, lists, strict=True)]
        self.table = points.memory.table(points.real, np.array([*chain.from_iterable(lists), 0.0]))

    @ti.func
    def acceleration(self, b, t):
        """Three packs, m/s², of pack b at time t, s."""
        zero = 0.0 * self.points.mass[b]
        ax, ay, az = zero, zero, zero
        for g in ti.static(range(len(self.groups))):
            if self.points.holds(g, b):
                a = self._alone(self.groups[g], b - self.points.firsts[g], b, t)
                ax, ay, az = zero + a[0], zero + a[1], zero + a[2]
        for j in ti.static(range(len(self.terms))):
            if self._concerns(j, b):
                c = self.terms[j].acceleration(self.loaded(j), b, t)
                ax, ay, az = ax + c[0], ay + c[1], az + c[2]
        return [ax, ay, az]

    @ti.func
    def end_step(self, b, t):
        """Let forces change what they keep of the particles of pack b at the end of a step."""
        for j in ti.static([j for j, term in enumerate(self.terms) if term.ends_steps]):
            if self._concerns(j, b):
                self.terms[j].end_step(self.loaded(j), b, t)

    @ti.func
    def linearize(self, b, t, by_position, by_velocity):
        """The diagonal blocks of all forces on pack b, as of `CoupledTerm.linearize`.

        Returns: six packs of those that act on each particle alone, and six of those that join particles.
        """
        zero = 0.0 * self.points.mass[b]
        xx, xy, xz, yy, yz, zz = zero, zero, zero, zero, zero, zero
        for g in ti.static(range(len(self.groups))):
            if self.points.holds(g, b):
                block = self._linearized(self.groups[g], b - self.points.firsts[g], b, t, by_position, by_velocity)
                xx, xy, xz = zero + block[0], zero + block[1], zero + block[2]
                yy, yz, zz = zero + block[3], zero + block[4], zero + block[5]
        alone = self._linearized_terms(False, b, t, by_position, by_velocity)
        own = [xx, xy, xz, yy, yz, zz]
        joined = self._linearized_terms(True, b, t, by_position, by_velocity)
        return [own[c] + alone[c] for c in ti.static(range(6))] + joined

    @ti.func
    def _linearized_terms(self, joins: ti.template(), b, t, by_position, by_velocity):
        """The sum of the diagonal blocks of the terms that join particles, or of those that do not."""
        zero = 0.0 * self.points.mass[b]
        xx, xy, xz, yy, yz, zz = zero, zero, zero, zero, zero, zero
        for j in ti.static([j for j, term in enumerate(self.terms) if term.joins == joins]):
            if self._concerns(j, b):
                block = self.terms[j].linearize(self.loaded(j), b, t, by_position, by_velocity)
                xx, xy, xz = xx + block[0], xy + block[1], xz + block[2]
                yy, yz, zz = yy + block[3], yz + block[4], zz + block[5]
        return [xx, xy, xz, yy, yz, zz]

    @ti.func
    def apply(self, b, vectors: ti.template()):
        """What all forces make of vectors beside the diagonal, three packs, as of `CoupledTerm.apply`."""
        zero = 0.0 * self.points.mass[b]
        x, y, z = zero, zero, zero
        for j in ti.static([j for j, term in enumerate(self.terms) if term.joins]):
            if self._concerns(j, b):
                part = self.terms[j].apply(b, vectors)
                x, y, z = x + part[0], y + part[1], z + part[2]
        return [x, y, z]

    @ti.func
    def _linearized(self, group: ti.template(), own, b, t, by_position, by_velocity):
        p = group.loaded()
        inverse_mass = group.component("inverse_mass", own, p[-1][Constant.INVERSE_MASS])
        state = self.points.position(b) + self.points.velocity(b)
        jacobians = group.motion.jacobian(p, state, t, [inverse_mass])
        mass = self.points.mass[b]
        return _definite(_symmetric(jacobians[0], jacobians[1], mass * by_position, mass * by_velocity), mass)

    @ti.func
    def _concerns(self, j: ti.template(), b):
        """Whether force j acts on the particles of pack b."""
        concerns = False
        for g in ti.static(self.terms[j].groups):
            concerns = concerns | self.points.holds(g, b)
        return concerns

    @ti.func
    def potential(self, j: ti.template(), b, t):
        """The potential energy of force j that the particles of pack b share in, a pack, J."""
        energy = 0.0 * self.points.mass[b]
        if self._concerns(j, b):
            energy = self.terms[j].potential(self.loaded(j), b, t)
        return energy

    @ti.func
    def _alone(self, group: ti.template(), own, b, t):
        """What the forces give that act on each particle alone; the pack is the group's own number `own`."""
        p = group.loaded()
        inverse_mass = group.component("inverse_mass", own, p[-1][Constant.INVERSE_MASS])
        state = self.points.position(b) + self.points.velocity(b)
        return group.motion.derivative(p, state, t, [inverse_mass])[3:]

    @ti.func
    def loaded(self, j: ti.template()):
        """The parameters of force j, in local variables."""
        return [bound(self.table[i]) for i in ti.static(range(self.spans[j][0], self.spans[j][1]))]


@ti.func
def _definite(block, mass):
    """A block that keeps half the mass, added to it, positive definite; zero in place of one that does not.

    Leading minors tell, by Sylvester's criterion, but for rounding.
    """
    xy, xz, yz = block[1], block[2], block[4]
    xx, yy, zz = block[0] + 0.5 * mass, block[3] + 0.5 * mass, block[5] + 0.5 * mass
    size = ti.abs(xx) + ti.abs(yy) + ti.abs(zz)
    minor = xx * yy - xy * xy
    det = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    keeps = (xx >= 0.0) & (yy >= 0.0) & (zz >= 0.0) & (minor >= -NOISE * size**2) & (det >= -NOISE * size**3)
    return [ti.select(keeps, block[c], 0.0) for c in ti.static(range(6))]


def _symmetric(by_position, by_velocity, first, second):
    """The entries xx, xy, xz, yy, yz, zz of the symmetric part of −first ∂a/∂x − second ∂a/∂v."""

    def entry(i, j):
        parts = [
            mul(-0.5, mul(factor, add(matrix[i][j], matrix[j][i])))
            for factor, matrix in ((first, by_position), (second, by_velocity))
        ]
        return add(*parts)

    return [entry(i, j) for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]

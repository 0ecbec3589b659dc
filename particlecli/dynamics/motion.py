"""The right-hand side of a group's equations of motion: its flows and forces, summed."""

from itertools import accumulate

import taichi as ti

from particlecli.dynamics import matrices
from particlecli.dynamics.algebra import total
from particlecli.dynamics.matrices import ZERO

STILL = [0.0, 0.0, 0.0]


@ti.data_oriented
class Motion:
    """d/dt [x, v] = [v, Σ a] (newtonian), or dx/dt = u(x, t) (first order).

    Attributes:
        flows: the flows the group needs, each a list of terms that add up.
        forces: its force terms.
        media: for each force the index of the flow it is relative to, or none.
        carrier: index of the flow that carries a first-order group, or none for a Newtonian one.
    """

    def __init__(self, flows, forces, media, carrier) -> None:
        self.flows = flows
        self.forces = forces
        self.media = media
        self.carrier = carrier
        self.first_order = carrier is not None
        self.firsts = [0, *accumulate(len(terms) for terms in flows)]

    @property
    def free(self):
        """The equations of motion of particles that rest on nothing: these."""
        return self

    def terms(self):
        """Every term that has parameters, in the order of their parameter lists."""
        return [term for flow in self.flows for term in flow] + list(self.forces)

    @ti.func
    def derivative(self, p, state, t, body):
        """Time derivative of a state, a list of as many packs.

        Args:
            p: one list of parameters for each of `terms()`.
            state: list of packs x, y, z, u, v, w (first order: the last three idle).
            t: s, one number or a pack.
            body: what stays the same during a step: [inverse mass in 1/kg, one number or a pack].
        """
        flows = [self._velocity(p, i, state[:3], t) for i in ti.static(range(len(self.flows)))]
        if ti.static(self.first_order):
            return flows[self.carrier] + STILL
        return state[3:] + self._acceleration(p, state, flows, t, body[0])

    @ti.func
    def jacobian(self, p, state, t, body):
        """The matrices ∂a/∂x, 1/s², and ∂a/∂v, 1/s; of a first-order group ∂u/∂x, 1/s, and zero.

        The arguments are those of `derivative`.
        """
        gradients = [self._gradient(p, i, state[:3], t) for i in ti.static(range(len(self.flows)))]
        if ti.static(self.first_order):
            return gradients[self.carrier], ZERO
        flows = [self._velocity(p, i, state[:3], t) for i in ti.static(range(len(self.flows)))]
        parts = [
            self.forces[j].jacobian(
                p[self.firsts[-1] + j],
                state[:3],
                state[3:],
                self._medium(flows, j),
                self._medium_gradient(gradients, j),
                t,
                body[0],
            )
            for j in ti.static(range(len(self.forces)))
        ]
        return matrices.total([part[0] for part in parts]), matrices.total([part[1] for part in parts])

    @ti.func
    def _gradient(self, p, flow: ti.template(), x, t):
        return matrices.total(
            [
                self.flows[flow][j].gradient(p[self.firsts[flow] + j], x, t)
                for j in ti.static(range(len(self.flows[flow])))
            ]
        )

    @ti.func
    def _velocity(self, p, flow: ti.template(), x, t):
        return total(
            [
                self.flows[flow][j].velocity(p[self.firsts[flow] + j], x, t)
                for j in ti.static(range(len(self.flows[flow])))
            ]
        )

    @ti.func
    def _acceleration(self, p, state, flows, t, inverse_mass):
        return total(
            [
                self.forces[j].acceleration(
                    p[self.firsts[-1] + j], state[:3], state[3:], self._medium(flows, j), t, inverse_mass
                )
                for j in ti.static(range(len(self.forces)))
            ]
        )

    def _medium(self, flows, force):
        return STILL if self.media[force] is None else flows[self.media[force]]

    def _medium_gradient(self, gradients, force):
        return ZERO if self.media[force] is None else gradients[self.media[force]]

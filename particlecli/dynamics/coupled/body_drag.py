"""Drag that depends on the direction of a body."""

from collections.abc import Sequence

import numpy as np
import taichi as ti

from particlecli.dynamics.coupled.base import CoupledTerm
from particlecli.dynamics.coupled.links import Lattice
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.group_plan import LANES, GroupPlan
from particlecli.scene import forces as scene
from particlecli.scene.shapes import LinkedLayout


class BodyDrag(CoupledTerm[scene.BodyDrag]):
    """F = −c (v·e) e − k (v − (v·e) e), c = a where v·e > 0, else b; e from the particle behind to the one ahead.

    Symbols: v velocity, m/s; e the body's direction, a unit vector; a, b, k coefficients along, backward and across,
    kg/s. Where the particles behind and ahead are at the same place, all motion is across.
    Source: resistive force theory, Gray & Hancock, J. Exp. Biol. 32 (1955) 802; with a ≠ b the scales of Miller's
    snakes, Computer Graphics 22 (SIGGRAPH 1988) 169.

    Args:
        plans: of all groups of `points`, in their order.
    """

    def __init__(self, spec: scene.BodyDrag, points: Points, groups: Sequence[int], plans: Sequence[GroupPlan]) -> None:
        super().__init__(spec, points, groups)
        tables = [_ends(plans[g]) for g in groups]
        self.first_rows = np.cumsum([0, *(table.shape[1] for table in tables)]).tolist()
        ends = np.concatenate(tables, axis=1)
        self.ends = ti.field(ti.types.vector(LANES, ti.i32), shape=ends.shape[:2])
        points.memory.view(self.ends, ends)

    def parameters(self) -> list[float]:
        """The coefficients along, backward and across."""
        backward = self.spec.along if self.spec.backward is None else self.spec.backward
        return [self.spec.along, backward, self.spec.across]

    @ti.func
    def acceleration(self, p, b, t):
        """Three packs, m/s²."""
        mass = self.points.mass[b]
        fx, fy, fz = 0.0 * mass, 0.0 * mass, 0.0 * mass
        for i in ti.static(range(len(self.groups))):
            if self.points.holds(self.groups[i], b):
                first = self.points.firsts[self.groups[i]]
                row = self.first_rows[i] + b - first
                behind, ahead = self.ends[0, row], self.ends[1, row]
                ex = self.points.gathered(0, ahead, first) - self.points.gathered(0, behind, first)
                ey = self.points.gathered(1, ahead, first) - self.points.gathered(1, behind, first)
                ez = self.points.gathered(2, ahead, first) - self.points.gathered(2, behind, first)
                u, v, w = self.points.state[3, b], self.points.state[4, b], self.points.state[5, b]
                size2 = ex * ex + ey * ey + ez * ez
                onward = ex * u + ey * v + ez * w
                share = ti.select(size2 > 0.0, onward / size2, 0.0)
                extra = (p[2] - ti.select(onward > 0.0, p[0], p[1])) * share
                fx, fy, fz = extra * ex - p[2] * u, extra * ey - p[2] * v, extra * ez - p[2] * w
        weight = ti.select(mass > 0.0, 1.0 / mass, 0.0)
        return [weight * fx, weight * fy, weight * fz]

    @ti.func
    def linearize(self, p, b, t, by_position, by_velocity):
        """As of `CoupledTerm`, as if the drag were that across in all directions: at least as damped."""
        zero = 0.0 * self.points.mass[b]
        drag = zero + by_velocity * ti.max(p[0], ti.max(p[1], p[2]))
        return [drag, zero, zero, drag, zero, drag]


def _ends(plan: GroupPlan):
    """The particles behind and ahead of each, shape (2, packs, 16)."""
    if not isinstance(plan.layout, LinkedLayout):
        raise ValueError(f"the particles of {plan.name} have no order")
    count = plan.births.total
    ends = np.tile(np.arange(-(-count // LANES) * LANES, dtype=np.int32), (2, 1))
    ends[:, :count] = Lattice.of(plan.layout).neighbours()
    return ends.reshape(2, -1, LANES)

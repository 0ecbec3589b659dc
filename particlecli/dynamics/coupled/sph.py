"""Weakly compressible fluid by smoothed particle hydrodynamics."""

from collections.abc import Sequence

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli.dynamics.algebra import add, dot, mul
from particlecli.dynamics.coupled.images import mirror_maps, periodic_maps
from particlecli.dynamics.coupled.local import LocalTerm
from particlecli.dynamics.coupled.neighbor_grid import INTEGERS
from particlecli.dynamics.coupled.neighbors import Periodic
from particlecli.dynamics.coupled.pairs import offset, over_neighbors, over_packs, target
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.coupled.smoothing import CubicSpline, Wendland
from particlecli.dynamics.group_plan import LANES
from particlecli.scene import forces as scene
from particlecli.scene.local_forces import Artificial
from particlecli.scene.planes import Plane


class Sph(LocalTerm[scene.Sph]):
    """a_i = −Σ_j m_j (p_i/ρ_i² + p_j/ρ_j² + Π_ij) ∇W(x_i − x_j), p = ρ₀c²/γ ((ρ/ρ₀)^γ − 1), ρ_i = Σ_j m_j W + δ_i.

    Symbols: W smoothing kernel of length h, m; ρ₀ density at rest, kg/m³ (kg/m² in two dimensions); c speed of sound,
    m/s; γ exponent. δ_i is 0 where density is summed up. By continuity, dρ_i/dt = Σ_j m_j (v_i − v_j)·∇W, which is the
    time derivative of that sum, so the density is the sum and a constant, δ_i = ρ₀ − Σ_j m_j W at the beginning: the
    equation is solved without error, and free surfaces begin at rest. Without viscosity the forces are the gradient
    of U = Σ_i m_i ∫ p/ρ² dρ; walls and faces are images of the fluid, so this holds at them too.
    Viscosity, where d·v < 0: Π = −α c h d·v / ((d² + 0.01 h²) ρ₀), artificial; or laminar, with ν in m²/s:
    2 ν Σ_j m_j/ρ₀ (d·∇W)/(d² + 0.01 h²) v, d and v being differences between i and j.
    Source: Monaghan, J. Comput. Phys. 110 (1994) 399 and Rep. Prog. Phys. 68 (2005) 1703; Morris, Fox & Zhu,
    J. Comput. Phys. 136 (1997) 214, with ρ₀ for the densities of pairs.

    Attributes:
        compressions: field of packs of points, ρ/ρ₀.
        surplus: likewise, δ, where density is by continuity.
    """

    has_potential = True

    def __init__(self, spec: scene.Sph, points: Points, groups: Sequence[int], planes: Sequence[Plane]) -> None:
        kernel = Wendland if spec.kernel == "wendland" else CubicSpline
        self.smoothing = kernel(spec.smoothing, spec.dimensions)
        self.artificial = isinstance(spec.viscosity, Artificial)
        box = spec.periodic
        maps = mirror_maps(planes, spec.slip) if box is None else periodic_maps(box.size)
        super().__init__(
            spec,
            points,
            groups,
            2.0 * spec.smoothing,
            moves=True,
            axes=spec.dimensions,
            periodic=None if box is None else Periodic(box.min, box.size),
            maps=maps,
        )
        self.continues = spec.density_by == "continuity"
        pack = ti.types.vector(LANES, points.real)
        self.compressions = ti.field(pack, shape=points.capacity)
        self._compressions = points.memory.view(self.compressions)
        self.surplus = ti.field(pack, shape=points.capacity if self.continues else 1)
        self._begins = True

    def parameters(self) -> list[float]:
        """1/(2h), α, α/h², ρ₀, ρ₀c²/γ, viscosity, 0.01 h²."""
        spec, h, height = self.spec, self.spec.smoothing, self.smoothing.height
        stiffness = spec.density * spec.sound_speed**2 / spec.exponent
        unit = spec.sound_speed * h if self.artificial else 2.0
        viscosity = spec.viscosity.value * unit / spec.density
        return [0.5 / h, height, height / h**2, spec.density, stiffness, viscosity, 0.01 * h * h]

    def rearranged(self) -> None:
        """Lists are of no use any more, and the fluid begins anew."""
        super().rearranged()
        self._begins = True

    def restart(self) -> None:
        """The fluid begins anew."""
        self._begins = True

    def prepare(self, time: float) -> None:
        """Densities, pressures, forces."""
        self._weigh()
        if self.neighbors.count:
            self._sum_forces(self.neighbors.rows, *self.neighbors.lists)

    def prepare_potential(self, time: float) -> None:
        """Densities and what energy they mean."""
        self._weigh()
        self._store_energies(self.points.packs)

    def fluid(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Density, kg/m³, and pressure, Pa, at the present stage of the points, lane by lane, shape (lanes,)."""
        self._weigh()
        compressions = self._compressions.array.reshape(-1).astype(np.float64)
        pressures = self.parameters()[4] * (compressions**self.spec.exponent - 1.0)
        return self.spec.density * compressions, pressures

    def _weigh(self) -> None:
        near = self.neighbors
        near.update()
        if not near.count:
            return
        if self._begins and self.continues:
            self._begin(near.rows, *near.lists)
        self._begins = False
        self._sum_densities(near.rows, *near.lists)
        near.refresh_images()

    @ti.func
    def density(self, p, d, distance2, here, there):
        """m_j W, and three zeros."""
        return [there[3] * p[1] * self.smoothing.value(ti.sqrt(distance2) * p[0]), 0.0, 0.0, 0.0]

    @ti.func
    def force(self, p, d, distance2, here, there):
        """The force by one neighbour, N."""
        # What is the same for all lanes comes first: it is computed once.
        weight = here[3] * (there[3] * p[2] * self.smoothing.slope(ti.sqrt(distance2) * p[0]))
        stress = here[7] + there[7]
        v = offset(self.neighbors.rows, here, there, 4)
        if ti.static(self.artificial):
            stress = stress - p[5] * ti.min(dot(d, v), 0.0) / (distance2 + p[6])
            push = weight * stress
            return [mul(push, d[c]) for c in ti.static(range(3))] + [0.0]
        drag = p[5] * distance2 / (distance2 + p[6])
        return [mul(weight, add(mul(stress, d[c]), mul(-drag, v[c]))) for c in ti.static(range(3))] + [0.0]

    @ti.kernel
    def _begin(self, rows: ti.template(), count: ti.i32, begins: INTEGERS, ends: INTEGERS, entries: INTEGERS):
        over_packs(self.settle_density, rows, ti.static((count, begins, ends, entries)))

    @ti.kernel
    def _sum_densities(self, rows: ti.template(), count: ti.i32, begins: INTEGERS, ends: INTEGERS, entries: INTEGERS):
        over_packs(self.press, rows, ti.static((count, begins, ends, entries)))

    @ti.func
    def settle_density(self, rows: ti.template(), lists: ti.template(), b, worker):
        """What the density at rest of the particles of a pack has more than the sum, see `over_packs`."""
        count, rest = lists[0], self.table[3]
        density = self._summed(rows, lists, b, worker)
        first = b * rows.width
        for k in range(ti.min(rows.width, count - first)):
            slot = rows.order[first + k]
            self.surplus[slot // LANES][slot % LANES] = rest - density[k]

    @ti.func
    def press(self, rows: ti.template(), lists: ti.template(), b, worker):
        """Pressures by densities of the particles of a pack, into the rows, see `over_packs`."""
        p, count = self.loaded(), lists[0]
        density = self._summed(rows, lists, b, worker)
        first = b * rows.width
        lanes = ti.min(rows.width, count - first)
        if ti.static(self.continues):
            for k in range(lanes):
                slot = rows.order[first + k]
                density[k] = density[k] + self.surplus[slot // LANES][slot % LANES]
        compression = density / p[3]
        if ti.static(not self.spec.tension):
            compression = ti.max(compression, 1.0)
        stress = p[4] * (self._power(compression, self.spec.exponent) - 1.0) / (p[3] * compression) ** 2
        for k in range(lanes):
            slot = rows.order[first + k]
            self.compressions[slot // LANES][slot % LANES] = compression[k]
            rows.moving[first + k][3] = stress[k]

    @ti.func
    def _summed(self, rows: ti.template(), lists: ti.template(), b, worker):
        """Σ m W of the particles of a pack."""
        p, here = self.loaded(), target(rows, b, lists[0])
        total = over_neighbors(self.density, p, rows, lists, b, here, worker)
        # A particle is its own neighbour too.
        return total[0] + here[3] * p[1]

    @ti.kernel
    def _store_energies(self, packs: ti.i32):
        for b in range(packs):
            p = self.loaded()
            self.energies[b] = self.points.mass[b] * (p[4] / p[3]) * self._work(self.compressions[b])

    @ti.func
    def _power(self, x, exponent: ti.template()):
        """x to a whole power."""
        result = x
        for _ in ti.static(range(exponent - 1)):
            result = result * x
        return result

    @ti.func
    def _work(self, x):
        """∫ (x^γ − 1)/x² dx from 1 to x."""
        rest = 1.0 / x
        if ti.static(self.spec.exponent == 1):
            return ti.log(x) + rest - 1.0
        else:
            last = ti.static(1.0 / (self.spec.exponent - 1.0)) if ti.static(self.spec.exponent > 1) else 0.0
            return last * self._power(x, self.spec.exponent - 1) + rest - (1.0 + last)

"""CoupledTerm: what every force between particles offers to the engine of coupled groups."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Generic, TypeVar

import taichi as ti

from particlecli.dynamics.coupled.points import Points
from particlecli.scene.force_model import ForceModel

Spec = TypeVar("Spec", bound=ForceModel)


@ti.data_oriented
class CoupledTerm(ABC, Generic[Spec]):
    """One force that particles exert on each other.

    The engine asks for accelerations pack by pack, packs in any order and on any thread: a term gathers what acts on
    the particles of a pack, always in the same order, and writes nothing. So results do not depend on threads, and
    action equals reaction to rounding where both are computed by the same formula.

    Before each evaluation of the forces `prepare` runs on the host if the term needs it; it may launch kernels that
    sort, bin or sum over `points` into fields of the term's own. Where no term needs it and particles are few, all
    steps of a frame run in one kernel.

    Args:
        spec: the force as the scene gives it.
        points: all particles of coupled groups.
        groups: the places in `points.names` of those that the force acts on and between; it is not asked for others.

    Attributes:
        needs_preparation: whether `prepare` must run before accelerations are asked for.
        ends_steps: whether `end_step` has something to do.
        has_potential: whether `potential` is there, so that the energy of what it acts on can be computed.
        joins: whether `apply` has something to do.
    """

    needs_preparation: bool = False
    ends_steps: bool = False
    has_potential: bool = False
    joins: bool = False

    def __init__(self, spec: Spec, points: Points, groups: Sequence[int]) -> None:
        self.spec = spec
        self.points = points
        self.groups = tuple(groups)

    @property
    def depends_on_velocity(self) -> bool:
        """Whether the acceleration depends on velocities."""
        return self.spec.depends_on_velocity

    def parameters(self) -> list[float]:
        """The numbers that the kernel gets when it runs; they are not frozen into it."""
        return []

    def rearranged(self) -> None:
        """Called when the numbers of particles have changed, so that particles stand in other lanes."""

    def restart(self) -> None:
        """Called when the scene begins anew."""

    def prepare(self, time: float) -> None:
        """Get ready for accelerations at the present stage of `points`, at a time in s.

        Raises:
            SimulationError: it cannot.
        """

    def prepare_potential(self, time: float) -> None:
        """Get ready for energies at the present stage of `points`, as `prepare` does for accelerations."""
        self.prepare(time)

    def settle(self) -> None:
        """Called at the end of a frame, before particles go back into the state of their groups."""

    @abstractmethod
    @ti.func
    def acceleration(self, p, b, t):
        """The acceleration of the particles of pack b of `points`, three packs, m/s².

        Args:
            p: the values of `parameters`, as scalars in registers.
            b: a pack of one of `groups`.
            t: time, s; a scalar.
        """

    @ti.func
    def linearize(self, p, b, t, by_position, by_velocity):
        """Get ready to be `apply`-ed at the present stage of `points`; and what acts back on particles themselves.

        Args:
            p, b, t: as of `acceleration`.
            by_position, by_velocity: factors f, s², and g, s.

        Returns:
            Six packs xx, xy, xz, yy, yz, zz of the blocks on the diagonal of −f ∂F/∂x − g ∂F/∂v, kg, without what
            would make it indefinite; zeros where the term does not know: then implicit steps are as for a force that
            does not depend on the state, right but not stable at any step.
        """
        return [0.0 * self.points.mass[b] for _ in ti.static(range(6))]

    @ti.func
    def apply(self, b, vectors: ti.template()):
        """Three packs: what the same matrix beside its diagonal makes of vectors at pack b."""
        return [0.0 * self.points.mass[b] for _ in ti.static(range(3))]

    @ti.func
    def end_step(self, p, b, t):
        """Change what the term keeps of the particles of pack b, and nothing else, at the end of a step."""

    @ti.func
    def potential(self, p, b, t):
        """The potential energy, J, that the particles of pack b share in: summed over all it is the whole energy.

        Of a pair each has half. Lanes without a particle have zero. Only where `has_potential` is true.
        """
        raise NotImplementedError

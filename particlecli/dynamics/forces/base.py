"""ForceTerm: what every force offers to the kernels of the groups it acts on."""

from abc import ABC, abstractmethod
from typing import Generic, TypeVar

import taichi as ti

from particlecli.scene.force_model import ForceModel

Spec = TypeVar("Spec", bound=ForceModel)


@ti.data_oriented
class ForceTerm(ABC, Generic[Spec]):
    """One force object as a group's kernel meets it.

    Attributes:
        spec: the force as the scene gives it.
        has_potential: whether `potential` is there, so that the energy of what it acts on can be computed.
    """

    has_potential: bool = False

    def __init__(self, spec: Spec) -> None:
        self.spec = spec

    @property
    def depends_on_velocity(self) -> bool:
        """Whether the acceleration depends on the particle's velocity."""
        return self.spec.depends_on_velocity

    def parameters(self) -> list[float]:
        """The numbers that the kernel gets when it runs; they are not frozen into it."""
        return []

    @abstractmethod
    @ti.func
    def acceleration(self, p, x, v, u, t, inverse_mass):
        """The acceleration, m/s².

        Args:
            p: the values of `parameters`, as scalars in registers.
            x: position, m; three packs.
            v: velocity, m/s; three packs.
            u: velocity of the flow that the force is relative to, m/s; zeros where it names none.
            t: time, s; a scalar or a pack.
            inverse_mass: 1/kg; a scalar or a pack.

        Returns:
            Three components, each a pack or a scalar; the Python float 0.0 where it is structurally zero.
        """

    @abstractmethod
    @ti.func
    def jacobian(self, p, x, v, u, gradient, t, inverse_mass):
        """The derivatives of the acceleration by position, 1/s², and by velocity, 1/s.

        The arguments are those of `acceleration`, and the gradient ∂u/∂x of the flow, 1/s.

        Returns:
            Two matrices of three rows (∂a_i/∂x_j) and (∂a_i/∂v_j), see `matrices`.
        """

    @ti.func
    def potential(self, p, x, t, inverse_mass):
        """The potential energy by mass, J/kg: the acceleration is −∇ of it. A pack or a scalar.

        The arguments are those of `acceleration`. Only where `has_potential` is true.
        """
        raise NotImplementedError

"""FlowTerm: what every velocity field of a medium offers to the kernels that ask for it."""

from abc import ABC, abstractmethod
from typing import Generic, TypeVar

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli.scene.types import SceneModel

Spec = TypeVar("Spec", bound=SceneModel)


@ti.data_oriented
class FlowTerm(ABC, Generic[Spec]):
    """One term of a flow u(x, t), m/s.

    Attributes:
        spec: the term as the scene gives it.
        table: numbers that the kernel reads row by row in a loop, shape (rows, columns); None for no table.
        rows: the field of scalars, of the table's shape, that whoever builds the kernel fills with it before.
    """

    table: NDArray[np.float64] | None = None
    rows: ti.ScalarField | None = None

    def __init__(self, spec: Spec) -> None:
        self.spec = spec

    def parameters(self) -> list[float]:
        """The numbers that the kernel gets when it runs; they are not frozen into it."""
        return []

    @abstractmethod
    @ti.func
    def velocity(self, p, x, t):
        """The velocity, m/s.

        Args:
            p: the values of `parameters`, as scalars in registers.
            x: position, m; three packs.
            t: time, s; a scalar or a pack.

        Returns:
            Three components, each a pack or a scalar; the Python float 0.0 where it is structurally zero.
        """

    @abstractmethod
    @ti.func
    def gradient(self, p, x, t):
        """The derivatives of the velocity by position, 1/s: three rows (∂u_i/∂x_j), see `matrices`.

        The arguments are those of `velocity`.
        """

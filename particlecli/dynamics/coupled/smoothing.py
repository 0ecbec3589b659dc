"""Smoothing kernels: bells W(r) of compact support 2 h, whose integral over the plane or space is 1."""

import math
from abc import ABC, abstractmethod

import taichi as ti


@ti.data_oriented
class Smoothing(ABC):
    """A bell as pair functions need it.

    Attributes:
        height: α, so that W = α f(r/h), 1/m² or 1/m³.
        length: h, m.
    """

    def __init__(self, length: float, dimensions: int) -> None:
        self.length = length
        self.height = self.heights()[dimensions] / length**dimensions

    @abstractmethod
    def heights(self) -> dict[int, float]:
        """α h^d by the number of dimensions d."""

    @abstractmethod
    @ti.func
    def value(self, q):
        """f for q = r/(2h) >= 0; zero from 1 on."""

    @abstractmethod
    @ti.func
    def slope(self, q):
        """−f′ h/r, so that ∇W = −α/h² slope d for an offset d; zero from 1 on."""


class Wendland(Smoothing):
    """f = (1 − q)⁴ (1 + 4q). Source: Wendland, Adv. Comput. Math. 4 (1995) 389."""

    def heights(self) -> dict[int, float]:
        """α h^d by the number of dimensions d."""
        return {2: 7.0 / (4.0 * math.pi), 3: 21.0 / (16.0 * math.pi)}

    @ti.func
    def value(self, q):
        """f."""
        s = ti.max(1.0 - q, 0.0)
        square = s * s
        return square * square * (1.0 + 4.0 * q)

    @ti.func
    def slope(self, q):
        """−f′ h/r."""
        s = ti.max(1.0 - q, 0.0)
        return 5.0 * s * s * s


class CubicSpline(Smoothing):
    """f = 1 − 6 q² + 6 q³ for q < 1/2, 2 (1 − q)³ for q < 1. Source: Monaghan & Lattanzio, A&A 149 (1985) 135."""

    def heights(self) -> dict[int, float]:
        """α h^d by the number of dimensions d."""
        return {2: 10.0 / (7.0 * math.pi), 3: 1.0 / math.pi}

    @ti.func
    def value(self, q):
        """f."""
        s = ti.max(1.0 - q, 0.0)
        return ti.select(q < 0.5, 1.0 + q * q * (6.0 * q - 6.0), 2.0 * s * s * s)

    @ti.func
    def slope(self, q):
        """−f′ h/r."""
        s = ti.max(1.0 - q, 0.0)
        return ti.select(q < 0.5, 3.0 - 4.5 * q, 1.5 * s * s / ti.max(q, 0.5))

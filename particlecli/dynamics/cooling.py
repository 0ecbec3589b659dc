"""Cooling of particles, in packs: Newton's law and radiation."""

import taichi as ti

from particlecli.dynamics import vector_math
from particlecli.dynamics.algebra import bound
from particlecli.scene.groups import Cooling


@ti.data_oriented
class CoolingTerm:
    """dT/dt = −rate (T − ambient) − radiative (T⁴ − ambient⁴), T in K.

    Newton's law alone is advanced exactly. With radiation a step is cut into classical Runge–Kutta steps short
    enough for the hottest particle.

    Args:
        cooling: the laws and their coefficients; Newton's rate is handed to each call: it may differ by particle.
        hottest: K; the highest temperature a particle can have.
        dt: longest step, s.
    """

    LARGEST_CHANGE = 0.2
    """Longest Runge–Kutta step, in relaxation times of the hottest particle; the error is then below 1e-6."""

    def __init__(self, cooling: Cooling, hottest: float, dt: float) -> None:
        self.newton = cooling.rate is not None
        self.coefficient = cooling.radiative or 0.0
        self.radiates = cooling.radiative is not None
        self.ambient = cooling.ambient
        relaxation = 4.0 * self.coefficient * max(hottest, self.ambient) ** 3 * dt
        self.substeps = max(1, int(relaxation / self.LARGEST_CHANGE + 1.0))

    def parameters(self) -> list[float]:
        """Values the kernel gets at run time."""
        return [self.ambient, self.coefficient]

    @ti.func
    def rate_of_change(self, p, temperature, rate):
        """dT/dt in K/s."""
        return bound(self._newton(p, temperature, rate) - self._radiation(p, temperature))

    @ti.func
    def _newton(self, p, temperature, rate):
        if ti.static(self.newton):
            return -rate * (temperature - p[0])
        return temperature * 0.0

    @ti.func
    def _radiation(self, p, temperature):
        if ti.static(self.radiates):
            square = temperature * temperature
            ambient = p[0] * p[0]
            return p[1] * (square * square - ambient * ambient)
        return temperature * 0.0

    @ti.func
    def step(self, p, temperature, rate, h):
        """The temperature after a time h."""
        result = temperature
        if ti.static(not self.radiates):
            result = p[0] + (temperature - p[0]) * vector_math.exp(-rate * h)
        else:
            part = h * ti.static(1.0 / self.substeps)
            for _ in range(self.substeps):
                first = self.rate_of_change(p, result, rate)
                second = self.rate_of_change(p, result + 0.5 * part * first, rate)
                third = self.rate_of_change(p, result + 0.5 * part * second, rate)
                fourth = self.rate_of_change(p, result + part * third, rate)
                result = result + part * (first + 2.0 * second + 2.0 * third + fourth) / 6.0
        return result

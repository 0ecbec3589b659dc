"""A million particles, four forces and one plane, RK4, eight steps a frame."""

from __future__ import annotations

from dataclasses import replace

from tests.benchmarks.dust import Dust
from tests.benchmarks.figures import Figure
from tests.benchmarks.peers import available
from tests.benchmarks.simulate import race

LEAST = 150.0
"""Million particle-steps a second."""


def measure() -> list[Figure]:
    """Particle-steps a second under gravity, linear and quadratic drag and a point mass."""
    peers = {name: peer for name, peer in available().items() if name in ("C++ unrolled", "NumPy")}
    dust = Dust(scheme="rk4", forces=4, frames=12)
    located = race("impacts located in time", dust, peers)
    classic = race("impacts at the end of a step", replace(dust, contact="end_of_step"), peers)
    return [replace(located, must=LEAST), replace(classic, must=LEAST)]

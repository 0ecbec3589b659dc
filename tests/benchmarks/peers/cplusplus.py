"""C++ by g++: sources beside this file, compiled when they are first needed into a temporary folder."""

from __future__ import annotations

import ctypes
import os
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from tests.benchmarks.contest import State
from tests.benchmarks.dust import STEPS, Dust

FLAGS = ("-O3", "-march=native", "-ffast-math", "-fopenmp")


@cache
def library(name: str = "dust") -> ctypes.CDLL:
    """The compiled peer."""
    # Threads that spin while they wait would take time from the contestant whose turn it is.
    os.environ["OMP_WAIT_POLICY"] = "passive"
    source = Path(__file__).with_name(f"{name}.cpp")
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / f"{name}.so"
        subprocess.run(["g++", *FLAGS, "-shared", "-fPIC", str(source), "-o", str(target)], check=True)
        return ctypes.CDLL(str(target))


class CPlusPlus:
    """Particles in an array for each component; the number of steps known when it runs."""

    variant = ""

    def __init__(self, dust: Dust, start: State) -> None:
        self._start = start
        self._rows = [np.array(row) for row in start]
        self._count = ctypes.c_int64(dust.count)
        self._numbers = np.array(
            [
                dust.dt,
                dust.gravity,
                dust.drag,
                dust.quadratic_drag,
                dust.mass_strength,
                dust.mass_height,
                dust.softening**2,
                dust.restitution,
                dust.friction,
            ],
            np.float32,
        )
        friction = "_friction" if dust.friction else ""
        self._frame = getattr(library(), f"{dust.scheme}_{dust.forces}{friction}{self.variant}")

    def restart(self) -> None:
        """Put all particles back to where they began."""
        for row, values in zip(self._rows, self._start, strict=True):
            row[:] = values

    def advance(self) -> None:
        """Advance all particles by a frame."""
        self._frame(*map(_pointer, self._rows), self._count, STEPS, _pointer(self._numbers))

    def state(self) -> State:
        """Where the particles are now."""
        return np.stack(self._rows)


class UnrolledCPlusPlus(CPlusPlus):
    """The number of steps compiled in, and unrolled."""

    variant = "_unrolled"


def _pointer(array: State) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)

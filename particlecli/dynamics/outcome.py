"""What a group's kernels report of an advance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NOBODY = 2**31 - 1
FAILED, DIED, CAREFULLY, RESTING = range(4)
"""Places in the flags a kernel raises: the first slot that is not finite (or NOBODY), whether a particle died, whether
some have to march again carefully, and how many of those began on a plane."""


@dataclass(frozen=True)
class Outcome:
    """What an advance reports.

    Attributes:
        failed_slot: the first slot whose particle is not finite any more, if any.
        died: whether any particle died.
        steps: steps taken, summed over all particles.
        evaluations: evaluations of the equations of motion, likewise; those to locate impacts are not counted.
    """

    failed_slot: int | None
    died: bool
    steps: int
    evaluations: int


def lowered_flags() -> NDArray[np.int32]:
    """Flags of which none is raised, shape (4,)."""
    return np.array([NOBODY, 0, 0, 0], dtype=np.int32)

"""Threads that go through the phases of a kernel together."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import taichi as ti

from particlecli import cores, runtime
from particlecli.dynamics.memory import FieldMemory

FEWEST = 64
"""Packs for each member of a team, at least: fewer take no longer than it takes to wake a thread."""

MOST = runtime.COMPILED_FOR
"""Members at most. Loops over them ask for so many threads, or Taichi starts as many as the machine had cores when it
compiled the kernel: to wait for one that is not started is to wait for ever."""

INTERRUPTIONS, ALONE = 8, 100
"""Cores that others want are taken from members at work: if that happens oftener than so many times in a launch, one
member works alone in so many of the next launches. Results are the same."""


@ti.data_oriented
class Team:
    """Members that share the packs of each phase, and wait for each other before the next one.

    A launch wakes the threads, which takes as long as what a phase does for tens of thousands of particles; a team is
    woken once for many phases:

        self.team.gather()
        ti.loop_config(block_dim=1, parallelize=MOST)
        for member in range(members):
            ...
            self.team.meet(members)
            ...

    Members keep their cores busy while they wait, and never are more than there are threads, or cores; with as many
    threads as cores each has its own, for the system often puts threads that it wakes for short work on the same. On
    systems other than Linux, where that cannot be asked for, one member does it all.

    Args:
        memory: of the system.
    """

    def __init__(self, memory: FieldMemory) -> None:
        self.arrivals = memory.table(ti.i32, np.zeros(1, np.int32))
        self._alone, self._settled = 0, False

    @contextmanager
    def working(self, packs: int) -> Iterator[int]:
        """How many share so many packs in a launch, which is made within; one if others want the cores as well."""
        most = min(runtime.threads(), cores.usable(), MOST, packs // FEWEST)
        if most < 2 or self._alone > 0 or not cores.known():
            self._alone -= 1
            yield 1
            return
        self._settle()
        before = cores.interruptions()
        yield most
        if cores.interruptions() - before > INTERRUPTIONS:
            self._alone = ALONE

    def _settle(self) -> None:
        """Let no two threads wait for each other on the same core, where there is none to spare."""
        if not self._settled and runtime.threads() >= cores.usable():
            cores.spread(runtime.workers())
        self._settled = True

    @ti.func
    def gather(self):
        """Nobody has arrived anywhere; a statement of a kernel, before its members are sent out."""
        self.arrivals[0] = 0

    @ti.func
    def share(self, member, members, count):
        """The first of so many turns that a member takes, and the end of its last."""
        return [member * count // members, (member + 1) * count // members]

    @ti.func
    def meet(self, members):
        """Wait until all have come so far; each sees what the others have written before."""
        arrived = ti.atomic_add(self.arrivals[0], 1)
        expected = (arrived // members + 1) * members
        # An addition of nothing reads what others add; a plain load might be moved out of the loop.
        while ti.atomic_add(self.arrivals[0], 0) < expected:
            pass

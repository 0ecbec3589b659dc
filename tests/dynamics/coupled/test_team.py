"""Members of a team share out what there is, wait for each other, and do not change what comes out."""

import numpy as np
import pytest
import taichi as ti

from particlecli import cores, runtime
from particlecli.dynamics.coupled import team
from particlecli.dynamics.coupled.team import Team
from particlecli.dynamics.memory import FieldMemory

PHASES, PLACES = 40, 7


@ti.data_oriented
class Chain:
    """In each phase every place gets the sum of all of them and its own number: any that comes too early is seen."""

    def __init__(self):
        memory = FieldMemory()
        self.team = Team(memory)
        self.values = ti.field(ti.i32, shape=(2, PLACES))
        self.view = memory.view(self.values)
        memory.open()

    @ti.kernel
    def run(self, members: ti.i32):
        self.team.gather()
        ti.loop_config(block_dim=1, parallelize=team.MOST)
        for member in range(members):
            first, last = self.team.share(member, members, PLACES)
            for phase in range(PHASES):
                for place in range(first, last):
                    total = place
                    for other in range(PLACES):
                        total += self.values[phase % 2, other]
                    self.values[1 - phase % 2, place] = total % 1009
                self.team.meet(members)


def expected():
    values = np.zeros(PLACES, np.int64)
    for _ in range(PHASES):
        values = (values.sum() + np.arange(PLACES)) % 1009
    return values


def test_members_wait_for_each_other():
    runtime.start("single", 3)
    chain = Chain()
    for members in (1, 2, 3):
        for _ in range(3):
            chain.view.array[...] = 0
            chain.run(members)
            np.testing.assert_array_equal(chain.view.array[PHASES % 2], expected())


@pytest.fixture
def pair():
    """A team of two threads whose launches are interrupted as often as is noted in a list, by and by."""
    runtime.start("single", 2)
    return Team(FieldMemory())


def working(found, packs, interrupted, monkeypatch):
    """How many members a launch gets that is interrupted so often."""
    counts = iter([0, interrupted])
    monkeypatch.setattr(cores, "interruptions", lambda: next(counts))
    with found.working(packs) as members:
        return members


@pytest.mark.skipif(not cores.known(), reason="threads are not told of")
def test_one_works_alone_where_there_is_little_to_do_and_while_others_want_the_cores(pair, monkeypatch):
    monkeypatch.setattr(cores, "usable", lambda: 2)
    monkeypatch.setattr(cores, "spread", lambda numbers: None)
    many = 2 * team.FEWEST
    assert working(pair, many - 1, 0, monkeypatch) == 1
    assert working(pair, many, team.INTERRUPTIONS, monkeypatch) == 2
    assert working(pair, many, team.INTERRUPTIONS + 1, monkeypatch) == 2
    assert [working(pair, many, 0, monkeypatch) for _ in range(team.ALONE + 1)] == [1] * team.ALONE + [2]
    monkeypatch.setattr(cores, "usable", lambda: 1)
    assert working(pair, many, 0, monkeypatch) == 1

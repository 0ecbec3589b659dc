"""Sums over the neighbours of a pack of particles."""

import taichi as ti

from particlecli.dynamics.algebra import add, bound, dot
from particlecli.dynamics.coupled.neighbor_lists import BEYOND
from particlecli.dynamics.coupled.sharing import BLOCK, WORKERS

ROW = 4
"""Quantities in a row of `Rows.at`, and as many in one of `Rows.moving`."""


@ti.func
def target(rows: ti.template(), b, count):
    """Packs x, y, z, m, and mass, kg [, u, v, w, m/s, and what else rows carry] of the particles of a pack.

    Behind the last particle lanes repeat it.
    """
    packs = []
    for c in ti.static(range(ROW)):
        packs.append(
            ti.Vector([rows.at[ti.min(b * rows.width + k, count - 1)][c] for k in ti.static(range(rows.width))])
        )
    if ti.static(rows.moves):
        for c in ti.static(range(ROW)):
            packs.append(
                ti.Vector([rows.moving[ti.min(b * rows.width + k, count - 1)][c] for k in ti.static(range(rows.width))])
            )
    return packs


@ti.func
def source(rows: ti.template(), row):
    """The same of one neighbour, scalars."""
    at = rows.at[row]
    if ti.static(rows.moves):
        moving = rows.moving[row]
        return [at[0], at[1], at[2], at[3], moving[0], moving[1], moving[2], moving[3]]
    return [at[0], at[1], at[2], at[3]]


def offset(rows, here, there, first=0):
    """The difference of two rows' positions, or of velocities from `first` = 4 on; literally 0 across a sheet."""
    differences = [bound(here[first + c] - there[first + c]) for c in range(rows.axes)]
    return differences + [0.0] * (3 - rows.axes)


@ti.func
def over_packs(work: ti.template(), rows: ti.template(), lists: ti.template()):
    """Let workers take blocks of packs until none are left; the only statement of a kernel.

    Args:
        work: called for each pack with rows, lists, the pack's number and the worker's.
        rows: particles and images.
        lists: see `Neighbors.lists`.
    """
    rows.counter[0] = 0
    ti.loop_config(block_dim=1)
    for worker in range(WORKERS):
        packs = lists[1].shape[0]
        first = ti.atomic_add(rows.counter[0], BLOCK)
        while first < packs:
            for b in range(first, ti.min(first + BLOCK, packs)):
                work(rows, lists, b, worker)
            first = ti.atomic_add(rows.counter[0], BLOCK)


@ti.func
def over_neighbors(what: ti.template(), p, rows: ti.template(), lists: ti.template(), b, here: ti.template(), worker):
    """Sums of up to four quantities over all that is within reach of each particle of pack b, itself left out.

    Args:
        what: called for each neighbour with p, the offset d from it (three packs, m, or literal zeros), the offset's
            square, and the rows of both; returns four packs, or literal zeros; they must vanish where the square is
            `BEYOND`.
        p: parameters.
        rows: particles and images.
        lists: see `Neighbors.lists`.
        here: the pack's own rows, from `target`.
        worker: who sums.

    Returns:
        Four packs. The order of summation is that of the rows, the pack's own first.
    """
    count, begins, ends, entries = ti.static(lists)
    zero = 0.0 * here[0]
    s0, s1, s2, s3 = zero, zero, zero, zero
    first = b * rows.width
    for k in range(ti.min(rows.width, count - first)):
        there = source(rows, first + k)
        d = offset(rows, here, there)
        itself = ti.Vector(list(range(rows.width))) == k
        apart = ti.select(itself, ti.cast(BEYOND, rows.real), dot(d, d))
        q = what(p, d, apart, here, there)
        s0, s1, s2, s3 = add(s0, q[0]), add(s1, q[1]), add(s2, q[2]), add(s3, q[3])
    for e in range(begins[b], ends[b]):
        there = source(rows, entries[e])
        d = offset(rows, here, there)
        q = what(p, d, dot(d, d), here, there)
        s0, s1, s2, s3 = add(s0, q[0]), add(s1, q[1]), add(s2, q[2]), add(s3, q[3])
    # LLVM vectorizes the loops from these stores; what is done with lanes later would mislead it.
    for c in ti.static(range(ROW)):
        rows.sums[worker, c] = [s0, s1, s2, s3][c]
    return [rows.sums[worker, c] for c in ti.static(range(ROW))]

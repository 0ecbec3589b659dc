"""The modes of particles that springs join, about the state they are born in."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.linalg import eigsh

from particlecli.dynamics.coupled.links import Lattice, places
from particlecli.dynamics.group_plan import GroupPlan
from particlecli.dynamics.masses import masses
from particlecli.dynamics.plan import Coupling
from particlecli.scene.forces import Springs
from particlecli.scene.shapes import LinkedLayout
from particlecli.stability.modes import Modes

Doubles = NDArray[np.float64]

ACCURACY = 1e-2
"""Relative accuracy of the squared frequency, which is found too small if anything."""

DENSE = 30
"""Up to so many coordinates all eigenvalues are computed."""


def fastest_modes(plan: GroupPlan, couplings: Iterable[Coupling]) -> Modes:
    """The two modes of the highest frequency that springs alone give a group; none where nothing is joined.

    M ẍ = −K x − D ẋ with K = Σ k L and D = Σ d L, where L = Σ n nᵀ over springs of one stiffness k and damping d, n
    along each. The eigenvector e of the largest eigenvalue κ of M^(−½) K M^(−½) and δ = eᵀ M^(−½) D M^(−½) e give
    α² + δα + κ = 0. Further forces that pull back only make the fastest mode faster, so a step that is too long for
    these is too long.
    """
    specs = [each.force for each in couplings if isinstance(each.force, Springs) and plan.name in each.groups]
    joined = [(spec, matrix) for spec in specs if (matrix := _matrix(spec, plan)) is not None]
    if not joined:
        return Modes.of_pairs(np.empty(0, complex))
    pull: csr_array = sum(spec.stiffness * matrix for spec, matrix in joined)
    drag: csr_array = sum(spec.damping * matrix for spec, matrix in joined)
    if pull.shape[0] <= DENSE:
        values, vectors = np.linalg.eigh(pull.toarray())
    else:
        start = np.random.default_rng(0).normal(size=pull.shape[0])
        values, vectors = eigsh(pull, k=1, which="LA", tol=ACCURACY, v0=start)
    fastest = vectors[:, -1]
    damping = float(fastest @ (drag @ fastest))
    return Modes.of_pairs(np.roots([1.0, damping, float(values[-1])]).astype(complex))


def _matrix(spec: Springs, plan: GroupPlan) -> csr_array | None:
    """M^(−½) L M^(−½), shape (3 n, 3 n)."""
    born = plan.births.table(0, plan.births.total).positions
    count = born.shape[1]
    pairs = joined_pairs(spec, plan)
    if not len(pairs):
        return None
    apart = born[:, pairs[:, 1]] - born[:, pairs[:, 0]]
    length = np.linalg.norm(apart, axis=0)
    along = np.divide(apart, length, out=np.zeros_like(apart), where=length > 0.0)
    roots = np.where(held(plan), 0.0, masses(plan, np.arange(count)) ** -0.5)
    rows = np.repeat(np.arange(len(pairs)), 6)
    columns = (3 * pairs[:, :, None] + np.arange(3)).reshape(-1)
    values = (np.stack([-roots[pairs[:, 0]], roots[pairs[:, 1]]], axis=1)[:, :, None] * along.T[:, None, :]).reshape(-1)
    links = coo_array((values, (rows, columns)), shape=(len(pairs), 3 * count)).tocsr()
    product: csr_array = links.T @ links
    return product


def joined_pairs(spec: Springs, plan: GroupPlan) -> NDArray[np.int64]:
    """The pairs of a group's particles that springs join, shape (m, 2)."""
    if spec.pairs is not None:
        return np.array(spec.pairs, np.int64)
    assert isinstance(plan.layout, LinkedLayout)
    return Lattice.of(plan.layout).pairs(spec.links or ("structural", "shear", "bend"))


def held(plan: GroupPlan) -> NDArray[np.bool_]:
    """Which particles of a group are pinned, shape (n,)."""
    born = plan.births.table(0, plan.births.total).positions
    count = born.shape[1]
    s, side = places(plan.layout, count)
    names = {**dict(zip("xyz", born, strict=True)), "s": s, "side": side}
    pinned = np.zeros(count, bool)
    for pin in plan.pins:
        pinned |= np.broadcast_to(pin.where.evaluate(names), count) != 0
    return pinned

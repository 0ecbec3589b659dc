"""The modes of particles that springs join, about the state they are born in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.linalg import eigsh

from particlecli.accuracy.measure import masses
from particlecli.accuracy.modes import Modes
from particlecli.dynamics.coupled.links import Lattice, places
from particlecli.dynamics.group_plan import GroupPlan
from particlecli.scene.forces import Springs
from particlecli.scene.shapes import LinkedLayout

Doubles = NDArray[np.float64]

ACCURACY = 1e-2
"""Relative accuracy of the squared frequency, which is found too small if anything."""

DENSE = 30
"""Up to so many coordinates all eigenvalues are computed."""


def fastest_modes(spec: Springs, plan: GroupPlan) -> Modes:
    """The two modes of the highest frequency that springs alone give their particles; none where nothing is joined.

    With the stiffness k and the damping d the same for all springs, M ẍ = −L (k x + d ẋ), L = Σ n nᵀ over the springs,
    n along each: an eigenvalue λ of M^(−½) L M^(−½) gives α² + d λ α + k λ = 0. Further forces that pull back only
    make the fastest mode faster, so a step that is too long for these is too long.
    """
    matrix = _matrix(spec, plan)
    if matrix is None:
        return Modes.of_pairs(np.empty(0, complex))
    if matrix.shape[0] <= DENSE:
        largest = float(np.linalg.eigvalsh(matrix.toarray())[-1])
    else:
        start = np.random.default_rng(0).normal(size=matrix.shape[0])
        found = eigsh(matrix, k=1, which="LA", tol=ACCURACY, v0=start, return_eigenvectors=False)
        largest = float(found[0])
    return Modes.of_pairs(np.roots([1.0, spec.damping * largest, spec.stiffness * largest]).astype(complex))


def _matrix(spec: Springs, plan: GroupPlan) -> csr_array | None:
    """M^(−½) L M^(−½), shape (3 n, 3 n)."""
    born = plan.births.table(0, plan.births.total).positions
    count = born.shape[1]
    if spec.pairs is not None:
        pairs = np.array(spec.pairs, np.int64)
    else:
        assert isinstance(plan.layout, LinkedLayout)
        pairs = Lattice.of(plan.layout).pairs(spec.links or ("structural", "shear", "bend"))
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

"""Which particles to keep of too many: always the same ones, and spread over all."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from particlecli.frame import Frame

Places = NDArray[np.intp]


def chosen(frame: Frame, most: int | None) -> Mapping[str, Places | slice]:
    """The places, in ascending order, of the particles of each group to keep; in all at most `most`.

    Every group keeps its share. Within a group those stay whose numbers have the smallest hashes, so that a
    particle that is chosen stays so until others with smaller hashes are born.
    """
    alive = frame.alive
    if most is None or alive <= most:
        return {name: slice(None) for name in frame.groups}
    return {name: _smallest(group.ids, most * len(group) // alive) for name, group in frame.groups.items()}


def _smallest(ids: NDArray[np.int64], count: int) -> Places:
    if count == 0:
        return np.empty(0, np.intp)
    return np.sort(np.argpartition(_hash(ids), count - 1)[:count])


def _hash(ids: NDArray[np.int64]) -> NDArray[np.uint64]:
    """The finalizer of splitmix64 (Steele, Lea & Flood 2014): a bijection, so no two particles tie."""
    mixed = ids.astype(np.uint64)
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        mixed = (mixed ^ (mixed >> np.uint64(shift))) * np.uint64(factor)
    return np.asarray(mixed ^ (mixed >> np.uint64(31)), np.uint64)

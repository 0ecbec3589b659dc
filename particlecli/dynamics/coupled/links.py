"""Which particles of a group are linked, and where in the body: lattices, and pairs listed one by one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from particlecli.scene.body_forces import Link
from particlecli.scene.shapes import GridLayout, HairLayout, Layout, LineLayout, LinkedLayout

Doubles = NDArray[np.float64]
Indices = NDArray[np.int64]

APART = 2**31 - 1
"""Instead of a step that partners do not share."""


@dataclass(frozen=True)
class Lattice:
    """Particles in rows, columns and layers, the first running fastest.

    Attributes:
        counts: particles along each of the three.
        linked: along which of them neighbours are linked.
    """

    counts: tuple[int, int, int]
    linked: tuple[bool, bool, bool] = (True, True, True)

    @classmethod
    def of(cls, layout: LinkedLayout) -> Lattice:
        """The lattice of a layout."""
        match layout:
            case GridLayout():
                return cls(layout.counts)
            case LineLayout():
                return cls((layout.count, 1, 1))
            case HairLayout():
                return cls((layout.count, layout.strands, 1), (True, False, False))

    @property
    def axes(self) -> list[int]:
        """The three, the one along the body first: the longest that is linked, then the longest of the others."""
        return sorted(range(3), key=lambda axis: (-self.linked[axis], -self.counts[axis], axis))

    def pairs(self, links: Sequence[Link]) -> Indices:
        """The numbers of the particles that links of these kinds join, shape (n, 2)."""
        numbers = np.arange(np.prod(self.counts)).reshape(self.counts, order="F")
        found = [self._joined(numbers, offset) for kind in dict.fromkeys(links) for offset in self._offsets(kind)]
        return np.concatenate([np.empty((0, 2), np.int64), *found])

    def _offsets(self, kind: Link) -> Iterator[tuple[int, ...]]:
        for offset in product(*((-1, 0, 1) if linked else (0,) for linked in self.linked)):
            size = sum(map(abs, offset))
            if offset <= (0, 0, 0):  # of two opposite ones the same link
                continue
            if kind == "bend" and size == 1:
                yield tuple(2 * step for step in offset)
            elif kind == ("structural" if size == 1 else "shear"):
                yield offset

    def _joined(self, numbers: Indices, offset: tuple[int, ...]) -> Indices:
        ends = [
            numbers[
                tuple(slice(max(0, -sign * step), max(0, n - max(0, sign * step))) for step, n in self._spans(offset))
            ]
            for sign in (1, -1)
        ]
        return np.stack([end.ravel(order="F") for end in ends], axis=1)

    def _spans(self, offset: tuple[int, ...]) -> list[tuple[int, int]]:
        return list(zip(offset, self.counts, strict=True))

    def places(self) -> tuple[Doubles, Doubles]:
        """Of each particle, s from 0 to 1 along the body, and side from −1 to 1 across; shape (n,) each."""
        along, across, _ = self.axes
        steps = np.unravel_index(np.arange(np.prod(self.counts)), self.counts, order="F")
        s = steps[along] / max(1, self.counts[along] - 1)
        side = 2.0 * steps[across] / max(1, self.counts[across] - 1) - 1.0 if self.counts[across] > 1 else 0.0 * s
        return s, side

    def neighbours(self) -> tuple[Indices, Indices]:
        """Of each particle the one behind and the one ahead along the body, itself where there is none."""
        along = self.axes[0]
        steps = list(np.unravel_index(np.arange(np.prod(self.counts)), self.counts, order="F"))
        ends = []
        for step in (-1, 1):
            moved = steps.copy()
            moved[along] = np.clip(steps[along] + step, 0, self.counts[along] - 1)
            ends.append(np.ravel_multi_index(moved, self.counts, order="F"))
        return ends[0], ends[1]


def places(layout: Layout | None, count: int) -> tuple[Doubles, Doubles]:
    """s and side, shape (count,), of each particle of a group; of one without order by number, and in the middle."""
    if isinstance(layout, LinkedLayout):
        return Lattice.of(layout).places()
    return np.arange(count) / max(1, count - 1), np.zeros(count)


@dataclass(frozen=True)
class Adjacency:
    """Whom each particle of a group is linked to, in packs of 16 lanes; both ends of a link have an entry.

    Attributes:
        starts: of each pack its first slot, and the end of the last; shape (packs + 1).
        partners: shape (slots, 16): the other end of a link of each lane's particle; itself where there is none.
        links: shape (slots, 16): the number of that link, −1 where there is none.
    """

    starts: NDArray[np.int32]
    partners: NDArray[np.int32]
    links: NDArray[np.int32]

    @classmethod
    def of(cls, pairs: Indices, count: int) -> Adjacency:
        """The adjacency of links between `count` particles.

        In packs where that takes no more slots, links to partners that stand equally far ahead or behind share a slot;
        elsewhere each particle's links are in their order.
        """
        owners, others = np.concatenate([pairs[:, 0], pairs[:, 1]]), np.concatenate([pairs[:, 1], pairs[:, 0]])
        numbers = np.tile(np.arange(len(pairs)), 2)
        order = np.lexsort((numbers, others, owners))
        owners, others, numbers = owners[order], others[order], numbers[order]
        rows = -(-count // 16)
        widths = np.bincount(owners, minlength=rows * 16).reshape(-1, 16).max(axis=1)
        again = _ranks(np.stack([owners, others], axis=1))
        keys, shared = np.unique(np.stack([owners // 16, others - owners, again], axis=1), axis=0, return_inverse=True)
        alike = np.bincount(keys[:, 0], minlength=rows) <= widths
        in_order = np.lexsort((numbers, owners))
        ranks = np.empty(len(owners), np.int64)
        ranks[in_order] = _ranks(owners[in_order][:, None])
        ranks = np.where(alike[owners // 16], _ranks(keys[:, :1])[shared.ravel()], ranks)
        starts = np.concatenate(([0], np.cumsum(widths)))
        packs = np.repeat(np.arange(rows), widths)
        partners = (packs[:, None] * 16 + np.arange(16)).astype(np.int32)
        links = np.full(partners.shape, -1, np.int32)
        slots, lanes = starts[owners // 16] + ranks, owners % 16
        partners[slots, lanes], links[slots, lanes] = others, numbers
        return cls(starts.astype(np.int32), partners, links)

    def steps(self) -> Indices:
        """How far ahead the partners in each slot stand, all of them; `APART` where that differs."""
        packs = np.repeat(np.arange(len(self.starts) - 1), np.diff(self.starts))
        steps = self.partners.astype(np.int64) - (packs[:, None] * 16 + np.arange(16))
        there = self.links >= 0
        low = np.where(there, steps, APART).min(axis=1, initial=APART)
        high = np.where(there, steps, -APART).max(axis=1, initial=-APART)
        return np.where(low == high, low, APART)


def _ranks(rows: Indices) -> Indices:
    """Of each row of a sorted table, the how manyth of its kind it is, from 0."""
    if not len(rows):
        return np.zeros(0, np.int64)
    first = np.concatenate(([True], (rows[1:] != rows[:-1]).any(axis=1)))
    places = np.arange(len(rows))
    return places - np.maximum.accumulate(np.where(first, places, 0))

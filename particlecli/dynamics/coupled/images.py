"""Images of particles: copies across the faces of a periodic box, mirror images behind plane walls.

What is near a wall or a face finds its missing neighbours among the images; the rest of the search knows nothing of
walls and boxes. An image is an affine map of its particle, so it moves as the particle does.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np
import taichi as ti
from numpy.typing import NDArray

from particlecli.dynamics.coupled.neighbor_grid import INTEGERS, VECTOR3
from particlecli.dynamics.coupled.neighbor_rows import REALS, Rows
from particlecli.dynamics.memory import FieldMemory
from particlecli.scene.planes import Plane

CHUNK = 16
"""Rows whose images are counted together."""

ROUNDING = 1e-5
"""How far rounding may move an image, as a share of the box that images are in."""


@dataclass(frozen=True)
class Map:
    """Where images are: x′ = A x + s, and how they move: v′ = B v.

    Attributes:
        linear: A, shape (3, 3).
        shift: s, m, shape (3,).
        velocity: B, shape (3, 3).
    """

    linear: NDArray[np.float64]
    shift: NDArray[np.float64]
    velocity: NDArray[np.float64]


def periodic_maps(size: Sequence[float]) -> list[Map]:
    """Copies in the adjacent boxes; the box has no faces along axes where its size, m, is 0."""
    one = np.eye(3)
    turns = product(*((-1, 0, 1) if length > 0 else (0,) for length in size))
    return [Map(one, np.array(turn) * np.array(size), one) for turn in turns if any(turn)]


def mirror_maps(planes: Sequence[Plane], slips: bool) -> list[Map]:
    """Mirror images behind planes, and in the edges and corners where planes stand upright on each other.

    Where walls do not let slip, images move backwards, so that they drag.
    """
    reflections = [_reflection(plane) for plane in planes]
    maps = []
    for several in range(1, 4):
        for chosen in combinations(range(len(planes)), several):
            if all(_upright(planes[a], planes[b]) for a, b in combinations(chosen, 2)):
                linear, shift = np.eye(3), np.zeros(3)
                for k in chosen:
                    linear, shift = reflections[k][0] @ linear, reflections[k][0] @ shift + reflections[k][1]
                maps.append(Map(linear, shift, linear if slips else -np.eye(3)))
    return maps


def _reflection(plane: Plane) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    n = np.array(plane.normal)
    return np.eye(3) - 2.0 * np.outer(n, n), 2.0 * (n @ np.array(plane.point)) * n


def _upright(a: Plane, b: Plane) -> bool:
    return abs(np.dot(a.normal, b.normal)) < 1e-9


@ti.data_oriented
class Images:
    """The images that stand near particles, and the rows that hold them, behind those of the particles.

    Attributes:
        maps: how many kinds there can be.
        copies: whether all are shifted only.
        sources, kinds: of each image the row of its particle and its map.
    """

    def __init__(self, maps: Sequence[Map], real, memory: FieldMemory) -> None:
        self.maps = len(maps)
        self.copies = all(np.array_equal(each.linear, np.eye(3)) for each in maps)
        self.linear = ti.Matrix.field(3, 3, real, shape=max(1, self.maps))
        self.shift = ti.Vector.field(3, real, shape=max(1, self.maps))
        self.velocity = ti.Matrix.field(3, 3, real, shape=max(1, self.maps))
        if maps:
            memory.view(self.linear, np.array([each.linear for each in maps]))
            memory.view(self.shift, np.array([each.shift for each in maps]))
            memory.view(self.velocity, np.array([each.velocity for each in maps]))
        self.sources = self.kinds = np.zeros(0, np.int32)

    def choose(self, rows: Rows, particles: int, low: NDArray[np.float64], high: NDArray[np.float64]) -> None:
        """Find the images within a box, in the order of their particles."""
        places = np.zeros(-(-particles // CHUNK) + 1, np.int32)
        box = ti.Vector(low), ti.Vector(high)
        self._count(rows, particles, *box, places)
        places = np.cumsum(places, dtype=np.int32)
        self.sources, self.kinds = np.empty(places[-1], np.int32), np.empty(places[-1], np.int32)
        self._fill(rows, particles, *box, places, self.sources, self.kinds)

    def arrange(self, order: NDArray[np.int32]) -> None:
        """Put the images in another order."""
        self.sources, self.kinds = self.sources[order], self.kinds[order]

    @ti.func
    def _image(self, rows: ti.template(), row, kind):
        at = rows.at[row]
        x = ti.Vector([at[0], at[1], at[2]])
        if ti.static(not self.copies):
            x = self.linear[kind] @ x
        return x + self.shift[kind]

    @ti.func
    def _within(self, rows: ti.template(), row, kind, low, high):
        p = self._image(rows, row, kind)
        inside = True
        for k in ti.static(range(3)):
            inside = inside & (p[k] >= low[k]) & (p[k] <= high[k])
        return inside

    @ti.func
    def _chunk_is_near(self, rows: ti.template(), first, stop, low, high):
        """Whether an image of rows first to stop may be within a box: where no image of the box around them is."""
        at = rows.at[first]
        nearest = ti.Vector([at[0], at[1], at[2]])
        farthest = nearest
        for row in range(first + 1, stop):
            for k in ti.static(range(3)):
                nearest[k] = ti.min(nearest[k], rows.at[row][k])
                farthest[k] = ti.max(farthest[k], rows.at[row][k])
        middle, half = 0.5 * (nearest + farthest), 0.5 * (farthest - nearest)
        slack = ROUNDING * (high - low)
        found = False
        for kind in range(self.maps):
            p = self.linear[kind] @ middle + self.shift[kind]
            reach = ti.abs(self.linear[kind]) @ half
            meets = True
            for k in ti.static(range(3)):
                meets = meets & (p[k] + reach[k] >= low[k] - slack[k]) & (p[k] - reach[k] <= high[k] + slack[k])
            found = found | meets
        return found

    @ti.kernel
    def _count(self, rows: ti.template(), particles: ti.i32, low: VECTOR3, high: VECTOR3, places: INTEGERS):
        ti.loop_config(block_dim=1)
        for chunk in range(places.shape[0] - 1):
            found, first, stop = 0, chunk * CHUNK, ti.min(particles, (chunk + 1) * CHUNK)
            if self._chunk_is_near(rows, first, stop, low, high):
                for row in range(first, stop):
                    for kind in range(self.maps):
                        found += ti.select(self._within(rows, row, kind, low, high), 1, 0)
            places[chunk + 1] = found

    @ti.kernel
    def _fill(
        self,
        rows: ti.template(),
        particles: ti.i32,
        low: VECTOR3,
        high: VECTOR3,
        places: INTEGERS,
        sources: INTEGERS,
        kinds: INTEGERS,
    ):
        ti.loop_config(block_dim=1)
        for chunk in range(places.shape[0] - 1):
            n = places[chunk]
            # Where a chunk has no image there is nothing to look for.
            if places[chunk + 1] > n:
                for row in range(chunk * CHUNK, ti.min(particles, (chunk + 1) * CHUNK)):
                    for kind in range(self.maps):
                        if self._within(rows, row, kind, low, high):
                            sources[n] = row
                            kinds[n] = kind
                            n += 1

    @ti.kernel
    def positions(self, rows: ti.template(), sources: INTEGERS, kinds: INTEGERS, positions: REALS):
        """Where the images are, m."""
        for i in range(sources.shape[0]):
            p = self._image(rows, sources[i], kinds[i])
            for k in ti.static(range(3)):
                positions[k, i] = ti.cast(p[k], ti.f64)

    @ti.kernel
    def refresh(self, rows: ti.template(), particles: ti.i32, sources: INTEGERS, kinds: INTEGERS):
        """Copy what particles are and do into the rows of their images."""
        for i in range(sources.shape[0]):
            p = self._image(rows, sources[i], kinds[i])
            rows.at[particles + i] = ti.Vector([p[0], p[1], p[2], rows.at[sources[i]][3]])
            if ti.static(rows.moves):
                m = rows.moving[sources[i]]
                v = self.velocity[kinds[i]] @ ti.Vector([m[0], m[1], m[2]])
                rows.moving[particles + i] = ti.Vector([v[0], v[1], v[2], m[3]])

"""Neighbors: for every pack of particles a list of all that is within reach, kept until something has moved too far."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import psutil
import taichi as ti
from numpy.typing import NDArray

from particlecli.dynamics.coupled.images import Images, Map
from particlecli.dynamics.coupled.neighbor_grid import Grid, bins_of, sort
from particlecli.dynamics.coupled.neighbor_lists import list_neighbors
from particlecli.dynamics.coupled.neighbor_rows import Rows
from particlecli.dynamics.coupled.points import Points
from particlecli.dynamics.coupled.sharing import BLOCK
from particlecli.dynamics.group_plan import LANES
from particlecli.errors import SimulationError

SKIN = 0.12
"""How much further than the cutoff lists reach at first, as a share of it."""

SHORT = 4
"""Lists that motion made useless after so many evaluations are followed by some that reach further."""

THIN = 1e-3
"""How thick a sheet may be, as a share of the cutoff."""

SAMPLE = 4096
"""Positions looked at to lay out the grid."""

SMALLEST_SHARE = 0.25
"""Share of the free memory that lists may take."""


@dataclass(frozen=True)
class Periodic:
    """A box whose opposite faces are joined, along axes in which it has a size.

    Attributes:
        low: its lower corner, m.
        size: m.
    """

    low: tuple[float, float, float]
    size: tuple[float, float, float]


class Neighbors:
    """Neighbours within a cutoff of the particles of some groups, by Verlet's lists.

    Lists belong to packs of particles that stand together, and hold every row that was within the cutoff and a skin of
    one of them when they were made. They hold until a particle has moved by half the skin, which grows where that is
    soon. Entries of a pack's list are in the order of the grid, and so are sums over them.

    Args:
        points: all coupled particles.
        groups: places of those that matter.
        cutoff: m.
        moves: whether velocities are wanted too.
        axes: 2 for a sheet in a plane z = constant.
        periodic: a box to fold positions into.
        maps: images to put behind walls and faces.

    Attributes:
        rows: what is in the lists.
        images: what stands behind walls and faces.
        count: acting particles: the first rows; images follow.
        builds: how often lists were made so far.

    Raises:
        SimulationError: by `update`: a position is not finite, a sheet is not flat, or there is not enough memory for
            the lists.
    """

    def __init__(
        self,
        points: Points,
        groups: Sequence[int],
        cutoff: float,
        *,
        moves: bool = False,
        axes: int = 3,
        periodic: Periodic | None = None,
        maps: Sequence[Map] = (),
    ) -> None:
        self.points = points
        self.groups = tuple(groups)
        self.cutoff = cutoff
        self.skin = SKIN * cutoff
        self.reach = cutoff + self.skin
        self.periodic = periodic
        self.images = Images(maps, points.real, points.memory)
        self.slots = points.capacity * LANES
        self.rows = Rows(points, self.slots + (self.slots // 2 + 64 if maps else 0), moves, axes)
        self.count = 0
        self.builds = 0
        self._spacing = 0.0
        self._stale = True
        self._uses = 0
        self.begins = self.ends = np.zeros(0, np.int32)
        self.entries = np.zeros(1, np.int32)
        self.capacity = 64 * BLOCK

    @property
    def packs(self) -> int:
        """Packs of targets."""
        return -(-self.count // self.rows.width)

    @property
    def lists(self) -> tuple[int, NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
        """What kernels need: how many particles act, where each pack's list begins and ends, and the lists."""
        return self.count, self.begins, self.ends, self.entries

    def forget(self) -> None:
        """The lists are of no use any more: particles stand in other lanes."""
        self._stale = True

    def update(self) -> bool:
        """Bring rows to the present stage of the points, and lists up to date; whether lists were made anew."""
        # A little less than half, because distances are rounded.
        moved = self.rows.refresh(self.groups, 0.49 * self.skin) != 0
        anew = moved or self._stale
        self._uses += 1
        if anew:
            if not self._stale and self._uses <= SHORT:
                self.skin = min(1.25 * self.skin, self.cutoff)
                self.reach = self.cutoff + self.skin
            self._uses = 0
            self._build()
        self.refresh_images()
        return anew

    def refresh_images(self) -> None:
        """Let images have what their particles have."""
        if self.images.maps:
            self.images.refresh(self.rows, self.count, self.images.sources, self.images.kinds)

    def _build(self) -> None:
        positions, acts = np.zeros((3, self.slots)), np.zeros(self.slots, np.int32)
        box = self.periodic or Periodic((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        self.rows.collect(self.groups, ti.Vector(box.low), ti.Vector(box.size), positions, acts)
        chosen = np.compress(acts != 0, positions, axis=1)
        if not np.isfinite(chosen).all():
            raise SimulationError("a particle's position is not finite any more; try a smaller integrator.dt")
        if self.rows.axes == 2 and chosen.size and np.ptp(chosen[2]) > THIN * self.cutoff:
            raise SimulationError(
                "a force in two dimensions acts on particles in one plane z = constant; these are not"
            )
        self.builds += 1
        self._stale = False
        self.count = chosen.shape[1]
        self.begins, self.ends = np.zeros((2, self.packs), np.int32)
        if not self.count:
            return
        sample = chosen[:, :: -(-self.count // SAMPLE)]
        if self._spacing == 0.0 or self.builds % 64 == 1:
            self._spacing = typical_spacing(chosen, self.reach)
        low, high = np.quantile(sample, (0.005, 0.995), axis=1)
        # Images stand beside their particles, but never above or below a sheet.
        margin = self.reach * (np.arange(3) < self.rows.axes) if self.images.maps else 0.0
        self.grid = lay_out(low - margin, high + margin, self._spacing, self.rows.width, self.count)
        starts, order = self._sorted(positions, acts)
        self.rows.settle(order, self.count)
        self.rows.refresh(self.groups, np.inf)
        image_starts = np.zeros(1, np.int32)
        if self.images.maps:
            self.images.choose(self.rows, self.count, chosen.min(axis=1) - self.reach, chosen.max(axis=1) + self.reach)
            if self.count + len(self.images.sources) > self.rows.room:
                self.rows = self.rows.enlarged(self.slots + 3 * len(self.images.sources) // 2)
                self._build()
                return
            image_starts = self._sort_images()
        self._list(starts, image_starts)

    def _sorted(
        self, positions: NDArray[np.float64], acts: NDArray[np.int32]
    ) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """The first place of each bin, and the positions that act in the order of their bins."""
        keys, order = np.empty((2, len(acts)), np.int32)
        starts = np.empty(self.grid.bins + 1, np.int32)
        bins_of(positions, acts, *self.grid.arguments, keys)
        sort(keys, starts, order)
        return starts, order

    def _sort_images(self) -> NDArray[np.int32]:
        images = self.images
        positions = np.empty((3, len(images.sources)))
        images.positions(self.rows, images.sources, images.kinds, positions)
        starts, order = self._sorted(positions, np.ones(positions.shape[1], np.int32))
        images.arrange(order)
        images.refresh(self.rows, self.count, images.sources, images.kinds)
        return starts

    def _list(self, starts: NDArray[np.int32], image_starts: NDArray[np.int32]) -> None:
        needs = np.zeros(-(-self.packs // BLOCK), np.int32)
        while True:
            if len(self.entries) < len(needs) * self.capacity:
                self._make_room(len(needs))
            list_neighbors(
                self.rows,
                self.count,
                *self.grid.arguments,
                self.reach,
                bool(self.images.maps),
                starts,
                image_starts,
                self.capacity,
                self.begins,
                self.ends,
                self.entries,
                needs,
            )
            longest = int(needs.max())
            # One place stays free: what is looked at last is written before it is known to be near.
            if longest < self.capacity:
                return
            self.capacity = longest + longest // 8 + 1

    def _make_room(self, blocks: int) -> None:
        needed, free = 4 * blocks * self.capacity, psutil.virtual_memory().available
        if needed > SMALLEST_SHARE * free or blocks * self.capacity >= 2**31:
            raise SimulationError(
                f"lists of about {self.capacity // BLOCK:,} neighbours for {self.count:,} particles would take "
                f"{needed / 2**30:.1f} GiB: particles stand far denser than their force's reach of {self.cutoff:.6g} m "
                "is made for. Try a smaller cutoff, a stronger repulsion, or fewer particles at the beginning"
            )
        self.entries = np.empty(blocks * self.capacity, np.int32)


def typical_spacing(positions: NDArray[np.float64], reach: float) -> float:
    """Distance of neighbours where most particles are, m, from the crowd that a particle sees around it."""
    low, high = positions.min(axis=1), positions.max(axis=1)
    places = np.floor((positions - low[:, None]) / reach)
    across = np.floor((high - low) / reach) + 1.0
    keys = (places[0] * across[1] + places[1]) * across[2] + places[2]
    crowds = np.unique(keys, return_counts=True)[1].astype(np.float64)
    crowd = max((crowds**2).sum() / crowds.sum(), 1.0)
    return float(reach / crowd ** (1.0 / flat_dimensions(low, high, reach)))


def flat_dimensions(low: NDArray[np.float64], high: NDArray[np.float64], reach: float) -> int:
    """In how many dimensions particles are spread out: two for a sheet that is thinner than the reach."""
    return max(1, int((high - low > 0.5 * reach).sum()))


def lay_out(low: NDArray[np.float64], high: NDArray[np.float64], spacing: float, width: int, count: int) -> Grid:
    """A grid over a box whose columns are so wide that a stretch as long as it is wide fills a pack."""
    extent = high - low
    axes = np.argsort(extent, kind="stable")
    extent = extent[axes]
    dimensions = max(1, int((extent > 0.5 * spacing).sum()))
    side = spacing * width ** (1.0 / dimensions)
    while True:
        sides = np.array([side, side, side / width])
        counts = np.maximum(1.0, np.ceil(extent / sides))
        if counts.prod() <= 8 * count + 64:
            break
        side *= 1.25
    return Grid(low=low[axes], sides=sides, counts=counts.astype(np.int32), axes=axes.astype(np.int32))

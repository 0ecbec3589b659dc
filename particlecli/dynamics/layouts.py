"""Where the particles of a group are at t = 0: listed, laid out, or read from a file."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from particlecli.dynamics.particle_files import ParticleList, read_particles
from particlecli.dynamics.random import Array, Draws
from particlecli.dynamics.shapes import perpendiculars, points
from particlecli.errors import Problem, SceneError
from particlecli.scene.groups import Particles
from particlecli.scene.shapes import (
    BallLayout,
    BoxLayout,
    CountedLayout,
    GridLayout,
    HairLayout,
    LatticeLayout,
    LineLayout,
)

GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))


def layout_count(layout: CountedLayout) -> int:
    """Number of particles in a layout."""
    if isinstance(layout, GridLayout):
        across, up, deep = layout.counts
        return across * up * deep
    if isinstance(layout, HairLayout):
        return layout.strands * layout.count
    return layout.count


def layout_positions(layout: CountedLayout, draws: Draws) -> Array:
    """Shape (3, n), m: positions of the particles whose indices `draws` has.

    On a grid the index runs along x first, then y, then z; on a line from start to end, on a strand of hair from the
    root to the tip, strand after strand.
    """
    match layout:
        case GridLayout():
            return _grid(layout, draws)
        case LineLayout():
            share = draws.indices / (layout.count - 1)
            ends = zip(layout.start, layout.end, strict=True)
            return np.stack([(1.0 - share) * low + share * high for low, high in ends])
        case HairLayout():
            return _hair(layout, draws)
        case BallLayout() | BoxLayout():
            return points(layout, draws)


def arrangement(name: str, group: Particles, folder: Path) -> ParticleList | CountedLayout:
    """The particles that a group lists, reads from its file or has on a lattice, or else its layout.

    Args:
        name: of the group.
        group: its part of the scene.
        folder: of the scene, where the file is.

    Raises:
        SceneError: the file cannot be used, or gives what the scene gives as well; a lattice is empty.
    """
    if isinstance(group.layout, LatticeLayout):
        return ParticleList(positions=_lattice(name, group.layout))
    if group.layout is not None:
        return group.layout
    if group.file is not None:
        listed = read_particles(Path(group.file), folder, f"particles.{name}.file")
        _refuse_twice_given(name, group, listed)
        return listed
    return ParticleList(
        positions=_columns(group.positions or ()),
        velocities=None if group.velocities is None else _columns(group.velocities),
        masses=None if group.masses is None else np.array(group.masses),
        temperatures=None if group.temperatures is None else np.array(group.temperatures),
    )


def _grid(layout: GridLayout, draws: Draws) -> Array:
    places = np.unravel_index(draws.indices.astype(np.int64), layout.counts, order="F")
    spacing = layout.spacing if isinstance(layout.spacing, tuple) else (layout.spacing,) * 3
    axes = zip(places, layout.counts, spacing, layout.center, strict=True)
    return np.stack([middle + (place - (count - 1) / 2) * gap for place, count, gap, middle in axes])


def _lattice(name: str, lattice: LatticeLayout) -> Array:
    """The index runs along x first, then y, then z."""
    places = np.indices(lattice.counts).transpose(0, 3, 2, 1).reshape(3, -1) + 0.5
    if lattice.pattern == "hexagonal":
        places[0] += np.where(np.floor(places[1]) % 2 == 0, -0.25, 0.25)
    corner = np.array(lattice.center) - np.array(lattice.size) / 2
    positions: Array = corner[:, None] + places * (np.array(lattice.size) / lattice.counts)[:, None]
    if lattice.where is None:
        return positions
    with np.errstate(all="ignore"):
        holds = lattice.where.evaluate(dict(zip("xyz", positions, strict=True))) > 0
    chosen = positions[:, np.broadcast_to(holds, positions.shape[1])]
    if chosen.shape[1] == 0:
        raise SceneError(
            [Problem(f"particles.{name}.layout.where", "holds nowhere in the box: there are no particles")]
        )
    return chosen


def _hair(layout: HairLayout, draws: Draws) -> Array:
    """Roots on a spiral of golden angles, which spreads them evenly over the area (Vogel 1979)."""
    strand, place = np.divmod(draws.indices.astype(np.int64), layout.count)
    share = (strand + 0.5) / layout.strands
    height = 1.0 - share * (1.0 - math.cos(math.radians(layout.spread)))
    around, across = GOLDEN_ANGLE * strand, np.sqrt(np.maximum(0.0, 1.0 - height**2))
    first, second = perpendiculars(layout.axis)
    outward = (
        np.outer(layout.axis, height)
        + np.outer(first, across * np.cos(around))
        + np.outer(second, across * np.sin(around))
    )
    reach = layout.radius + layout.length * place / (layout.count - 1)
    return np.array(layout.center)[:, None] + reach * outward


def _columns(rows: tuple[tuple[float, float, float], ...]) -> Array:
    return np.ascontiguousarray(np.array(rows, np.float64).T)


def _refuse_twice_given(name: str, group: Particles, listed: ParticleList) -> None:
    pairs = (("velocity", listed.velocities), ("mass", listed.masses), ("temperature", listed.temperatures))
    problems = [
        Problem(f"particles.{name}.{key}", f"`{group.file}` gives it as well; leave out one of the two")
        for key, column in pairs
        if column is not None and getattr(group, key) != Particles.model_fields[key].default
    ]
    if problems:
        raise SceneError(problems)

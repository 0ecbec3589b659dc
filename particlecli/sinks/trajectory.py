"""Every particle at chosen frames, as one flat table: .npz for NumPy, .csv for everything else."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from particlecli.errors import UsageError
from particlecli.frame import Floats, Frame, GroupFrame
from particlecli.sinks.base import Image, Sink
from particlecli.sinks.pending import Pending, writing
from particlecli.sinks.tables import Block, CsvTable, NpzTable

_TABLES: dict[str, type[NpzTable] | type[CsvTable]] = {".npz": NpzTable, ".csv": CsvTable}


class TrajectorySink(Sink):
    """Writes one row a particle and frame: time, frame, group, id, position, velocity, temperature.

    Velocity and temperature are there when some group has them, and not-a-number (an empty cell in .csv) for
    the others. The numbers keep the precision of the simulation. Memory does not grow with the run.
    """

    def __init__(self, path: Path, *, every: int = 1) -> None:
        """Prepares a trajectory.

        Args:
            path: final name, ending in .npz or .csv.
            every: write each so many frames, the first included.

        Raises:
            UsageError: an ending that names no known format.
        """
        table = _TABLES.get(path.suffix.lower())
        if table is None:
            raise UsageError(f"a trajectory ends in {', '.join(_TABLES)}; {path.name!r} does not")
        self._make = table
        self._pending = Pending(path)
        self._every = every
        self._table: NpzTable | CsvTable | None = None

    @property
    def files(self) -> tuple[Path, ...]:
        """The table."""
        return (self._pending.path,)

    def needs(self, group: str) -> frozenset[str]:  # noqa: ARG002
        """Velocities and temperatures, of the groups that have them."""
        return frozenset({"velocities", "temperatures"})

    def open(self) -> None:
        """Starts the table."""
        self._pending.claim()
        with writing(self._pending.path):
            self._table = self._make(self._pending.temporary)

    def write(self, frame: Frame, image: Image | None) -> None:  # noqa: ARG002
        """Adds the particles of a frame."""
        assert self._table is not None
        if frame.index % self._every:
            return
        with writing(self._pending.path):
            self._table.append(tuple(frame.groups), _rows(frame))

    def close(self) -> None:
        """Completes the table and gives it its name."""
        assert self._table is not None
        with writing(self._pending.path):
            self._table.finish()
        self._table = None
        self._pending.commit()

    def abort(self) -> None:
        """Removes what was written."""
        if self._table is not None:
            self._table.discard()
            self._table = None
            self._pending.discard()


def _rows(frame: Frame) -> Block:
    """The columns of one frame, one row a particle, the groups one after the other."""
    groups = list(frame.groups.values())
    counts = [len(group) for group in groups]
    block: Block = {
        "time": np.full(sum(counts), frame.time),
        "frame": np.full(sum(counts), frame.index, np.int32),
        "group": np.repeat(np.arange(len(groups), dtype=np.int32), counts),
        "id": np.concatenate([np.empty(0, np.int64), *(group.ids for group in groups)]),
        "position": np.concatenate([group.positions for group in groups]) if groups else np.empty((0, 3)),
    }
    if any(group.velocities is not None for group in groups):
        block["velocity"] = np.concatenate([_or_nan(group.velocities, group, (3,)) for group in groups])
    if any(group.temperatures is not None for group in groups):
        block["temperature"] = np.concatenate([_or_nan(group.temperatures, group, ()) for group in groups])
    return block


def _or_nan(values: Floats | None, group: GroupFrame, shape: tuple[int, ...]) -> Floats:
    return np.full((len(group), *shape), np.nan, group.positions.dtype) if values is None else values

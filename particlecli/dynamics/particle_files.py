"""Particles read from a file beside the scene: a table (.csv) or arrays (.npz)."""

from __future__ import annotations

import csv
import difflib
import math
import warnings
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from particlecli.dynamics.random import Array
from particlecli.errors import Problem, SceneError

COORDINATES = ("x", "y", "z")
VELOCITIES = ("vx", "vy", "vz")
COLUMNS = (*COORDINATES, *VELOCITIES, "mass", "temperature")
POSITIVE_COLUMNS = ("mass", "temperature")
ARRAYS = {"positions": 2, "velocities": 2, "masses": 1, "temperatures": 1}
"""Arrays in an archive and how many dimensions each has."""

UNREADABLE = (OSError, ValueError, EOFError, MemoryError, NotImplementedError, zipfile.BadZipFile, zlib.error)


@dataclass(frozen=True)
class ParticleList:
    """Particles given one by one.

    Attributes:
        positions: shape (3, n), m.
        velocities: shape (3, n), m/s; None where not given.
        masses: shape (n,), kg; None where not given.
        temperatures: shape (n,), K; None where not given.
    """

    positions: Array
    velocities: Array | None = None
    masses: Array | None = None
    temperatures: Array | None = None

    def __len__(self) -> int:
        return len(self.positions[0])

    def part(self, which: slice | NDArray[np.int64]) -> ParticleList:
        """Some of them; a slice takes no copy."""
        return ParticleList(
            self.positions[:, which],
            None if self.velocities is None else self.velocities[:, which],
            None if self.masses is None else self.masses[which],
            None if self.temperatures is None else self.temperatures[which],
        )


def read_particles(path: Path, folder: Path, key: str) -> ParticleList:
    """The particles in a file.

    Args:
        path: the file, absolute or relative to the folder.
        folder: the scene's folder, which the file must be in.
        key: the scene's key that names the file, for messages.

    Raises:
        SceneError: the file is outside the folder, cannot be read, lacks positions, or has columns, arrays or
            shapes that are unknown, or values that are no numbers, not finite or, for masses and
            temperatures, not positive.
    """
    whole = (folder / path).resolve()
    try:
        if not whole.is_relative_to(folder.resolve()):
            raise ValueError("lies outside the scene's folder; a scene reads only what is beside or below it")
        match whole.suffix.lower():
            case ".csv":
                return _from_table(whole)
            case ".npz":
                return _from_archive(whole)
        raise ValueError("must end in .csv or .npz")
    except FileNotFoundError:
        message = "there is no such file beside the scene"
    except UnicodeDecodeError:
        message = "is not a text file"
    except UNREADABLE as error:
        message = str(error) or "cannot be read"
    raise SceneError([Problem(key, f"`{path}`: {message}")])


def _from_table(path: Path) -> ParticleList:
    with path.open(newline="", encoding="utf-8-sig") as file:
        columns = _header(file)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of an empty table, which is reported below
                table = np.loadtxt(file, delimiter=",", comments=None, quotechar='"', ndmin=2).T
        except ValueError as error:
            raise ValueError(_first_fault(path, columns) or str(error)) from None
    if not table.size:
        raise ValueError("holds no particles")
    if len(table) != len(columns) or not _sound(table, columns):
        raise ValueError(_first_fault(path, columns) or f"does not have {len(columns)} columns")
    named = dict(zip(columns, table, strict=True))
    return ParticleList(
        positions=np.stack([named[name] for name in COORDINATES]),
        velocities=np.stack([named[name] for name in VELOCITIES]) if "vx" in named else None,
        masses=_copied(named.get("mass")),
        temperatures=_copied(named.get("temperature")),
    )


def _header(file: Iterator[str]) -> list[str]:
    columns = [name.strip() for name in next((row for row in csv.reader(file) if row), [])]
    if not columns:
        raise ValueError(f"is empty; its first line names the columns: {', '.join(COLUMNS)}")
    for name in columns:
        if name not in COLUMNS:
            raise ValueError(_unknown("column", name, COLUMNS))
        if columns.count(name) > 1:
            raise ValueError(f"column `{name}` is there twice")
    needed = COORDINATES + (VELOCITIES if set(columns) & set(VELOCITIES) else ())
    for name in needed:
        if name not in columns:
            raise ValueError(f"column `{name}` is missing; {', '.join(needed)} belong together")
    return columns


def _sound(table: Array, columns: Sequence[str]) -> bool:
    positive = [column for name, column in zip(columns, table, strict=True) if name in POSITIVE_COLUMNS]
    return bool(np.isfinite(table).all() and all((column > 0).all() for column in positive))


def _first_fault(path: Path, columns: Sequence[str]) -> str | None:
    """What is wrong with the first bad row, by its line; the fast reader does not tell well enough."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        rows = csv.reader(file)
        filled = (row for row in rows if row)
        next(filled)
        for row in filled:
            if len(row) != len(columns):
                return f"line {rows.line_num} has {len(row)} values under {len(columns)} column names"
            for name, text in zip(columns, row, strict=True):
                if fault := _fault(name, text.strip()):
                    return f"line {rows.line_num}, column {name}: {fault}"
    return None


def _fault(name: str, text: str) -> str | None:
    try:
        value = float(text)
    except ValueError:
        return f"`{text}` is not a number" if text else "there is no value"
    if not math.isfinite(value):
        return f"`{text}` is not finite"
    return f"`{text}` is not positive" if name in POSITIVE_COLUMNS and value <= 0 else None


def _from_archive(path: Path) -> ParticleList:
    arrays = _arrays(path)
    for name in arrays:
        if name not in ARRAYS:
            raise ValueError(_unknown("array", name, tuple(ARRAYS)))
    if "positions" not in arrays:
        raise ValueError("has no array `positions`")
    count = len(arrays["positions"]) if arrays["positions"].ndim else 0
    columns = {name: _checked(name, array, count) for name, array in arrays.items()}
    return ParticleList(**columns)


def _arrays(path: Path) -> dict[str, NDArray[Any]]:
    try:
        archive = np.load(path, allow_pickle=False)
        if isinstance(archive, np.lib.npyio.NpzFile):
            with archive:
                return dict(archive)
    except (ValueError, EOFError, zipfile.BadZipFile):
        pass  # in words of pickles and zip files, which help nobody
    raise ValueError("is not an archive of arrays of numbers, as np.savez(file, positions=…) writes it")


def _checked(name: str, array: NDArray[Any], count: int) -> Array:
    expected = (count, 3) if ARRAYS[name] == 2 else (count,)
    if array.shape != expected:
        wanted = "(n, 3)" if name == "positions" else str(expected)
        raise ValueError(f"`{name}` has shape {array.shape} instead of {wanted}")
    if array.dtype.kind not in "fiu":
        raise ValueError(f"`{name}` holds {array.dtype} instead of numbers")
    if not count:
        raise ValueError("holds no particles")
    values = np.ascontiguousarray(array.T, dtype=np.float64)
    wrong = ~np.isfinite(values)
    if ARRAYS[name] == 1:
        wrong |= values <= 0
    if wrong.any():
        row = int(np.argmax(wrong.any(axis=0) if values.ndim == 2 else wrong))
        fault = "not finite" if not np.isfinite(array[row]).all() else "not positive"
        raise ValueError(f"`{name}` is {fault} in row {row}: {array[row]}")
    return values


def _copied(column: Array | None) -> Array | None:
    return None if column is None else np.ascontiguousarray(column)


def _unknown(kind: str, name: str, known: Sequence[str]) -> str:
    nearest = difflib.get_close_matches(name.lower(), known, 1)
    suggestion = f"did you mean `{nearest[0]}`? " if nearest else ""
    return f"unknown {kind} `{name}`; {suggestion}Known are {', '.join(known)}"

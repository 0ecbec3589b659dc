"""Tables on disk that grow block by block, with the same bytes for the same rows."""

from __future__ import annotations

import shutil
import tempfile
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

Block = dict[str, NDArray[Any]]
"""Columns by name, equally many rows each; a column is a number, shape (n,), or a vector, shape (n, 3)."""


class NpzTable:
    """A .npz archive with one array a column, and `groups`, the names that the column `group` counts from 0.

    Each column grows in an anonymous file beside the archive, which is put together at the end.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._files: dict[str, IO[bytes]] = {}
        self._forms: dict[str, tuple[np.dtype[Any], tuple[int, ...]]] = {}
        self._groups: Sequence[str] = ()
        self._rows = 0

    def append(self, groups: Sequence[str], block: Block) -> None:
        """Adds rows; the columns and their types are those of the first block."""
        self._groups = groups
        self._rows += len(block["id"])
        for name, column in block.items():
            if name not in self._files:
                self._files[name] = tempfile.TemporaryFile(dir=self._path.parent)  # noqa: SIM115
                self._forms[name] = column.dtype.newbyteorder("<"), column.shape[1:]
            values = np.ascontiguousarray(column, dtype=self._forms[name][0])
            self._files[name].write(values.data)

    def finish(self) -> None:
        """Puts the archive together."""
        with zipfile.ZipFile(self._path, "w") as archive:
            for name, file in self._files.items():
                kind, shape = self._forms[name]
                file.seek(0)
                with _member(archive, name) as member:
                    _write_header(member, kind, (self._rows, *shape))
                    shutil.copyfileobj(file, member, 1 << 20)
            with _member(archive, "groups") as member:
                np.lib.format.write_array(member, np.array(self._groups, dtype=np.str_), allow_pickle=False)
        self.discard()

    def discard(self) -> None:
        """Lets go of the columns."""
        for file in self._files.values():
            with suppress(OSError):
                file.close()


def _member(archive: zipfile.ZipFile, name: str) -> IO[bytes]:
    # A ZipInfo made by hand is dated 1980, so the bytes do not tell when they were written.
    return archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True)


def _write_header(file: IO[bytes], kind: np.dtype[Any], shape: tuple[int, ...]) -> None:
    header = {"descr": np.lib.format.dtype_to_descr(kind), "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(file, header)


class CsvTable:
    """A text table with a header; numbers are the shortest that read back to the same value."""

    _VECTORS: Mapping[str, Sequence[str]] = {"position": ("x", "y", "z"), "velocity": ("vx", "vy", "vz")}

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", encoding="ascii", newline="\n")
        self._header: list[str] | None = None

    def append(self, groups: Sequence[str], block: Block) -> None:
        """Adds rows; the first block also gives the header."""
        if self._header is None:
            self._header = [title for name in block for title in self._VECTORS.get(name, (name,))]
            self._file.write(",".join(self._header) + "\n")
        columns: list[Iterable[str]] = []
        for name, values in block.items():
            if name == "group":
                columns.append([groups[index] for index in values])
            else:
                columns.extend(_texts(column) for column in np.atleast_2d(values.T))
        self._file.writelines(",".join(row) + "\n" for row in zip(*columns, strict=True))

    def finish(self) -> None:
        """Writes what is still buffered."""
        self._file.close()

    def discard(self) -> None:
        """Closes the file, whatever is lost."""
        with suppress(OSError):
            self._file.close()


def _texts(values: NDArray[Any]) -> list[str]:
    if values.dtype.kind != "f":
        return [str(value) for value in values.tolist()]
    if values.dtype == np.float64:
        return ["" if value != value else repr(value) for value in values.tolist()]
    return ["" if value != value else str(value) for value in values]

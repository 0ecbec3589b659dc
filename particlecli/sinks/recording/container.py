"""The outside of a recording's file: whose it is, and whether all of it is there. Does without Rerun.

A file is a header, messages that each state their kind and length, and a footer (RRF2 as Rerun 0.41 writes it).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from particlecli.errors import UsageError

_MAGIC = b"RRF2"
_OLDER = (b"RRF0", b"RRF1", b"RRIO")
_HEADER = struct.Struct("<4s4B4s")
_MESSAGE = struct.Struct("<QQ")
_FOOTER = b"RRF2FOOT"
_FOOTER_BYTES = 32


@dataclass(frozen=True)
class Container:
    """A file that is a recording of the Rerun in use.

    Attributes:
        path: the file.
        version: the Rerun that wrote it, such as 0.41.0.
        finished: whether it has its footer: its writer came to the end.
        whole: bytes up to the end of the last message that is all there.
        size: bytes.
    """

    path: Path
    version: str
    finished: bool
    whole: int
    size: int


def examine(path: Path) -> Container:
    """Looks at the outside of a recording.

    Raises:
        UsageError: there is no such file, it is no recording, or one of another Rerun version.
    """
    try:
        with path.open("rb") as file:
            header = file.read(_HEADER.size)
    except IsADirectoryError:
        raise UsageError(f"{path} is a folder; name the recording in it") from None
    except OSError as error:
        raise UsageError(f"{path}: {(error.strerror or str(error)).lower()}") from None
    if header[:4] in _OLDER:
        raise UsageError(f"{path} is a recording of an old Rerun version; this particlecli reads those of {_ours()}")
    if header[:4] != _MAGIC:
        raise UsageError(f"{path} is not a Rerun recording")
    if len(header) < _HEADER.size:
        raise UsageError(f"{path} is cut short: nothing of the recording is left")
    _, major, minor, patch, _, _ = _HEADER.unpack(header)
    written = f"{major}.{minor}.{patch}"
    if f"{major}.{minor}" != _ours().rpartition(".")[0]:
        raise UsageError(
            f"{path} was written by Rerun {written}; this particlecli reads recordings of Rerun {_ours()} "
            "(`rerun rrd migrate` brings older ones up to date)"
        )
    return Container(path, written, is_finished(path), _whole(path), path.stat().st_size)


def is_finished(path: Path) -> bool:
    """Whether a recording has its footer."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - _FOOTER_BYTES))
        return _FOOTER in file.read()


def _ours() -> str:
    return version("rerun-sdk")


def _whole(path: Path) -> int:
    size = path.stat().st_size
    end = _HEADER.size
    with path.open("rb") as file:
        file.seek(end)
        while len(head := file.read(_MESSAGE.size)) == _MESSAGE.size:
            length = _MESSAGE.unpack(head)[1]
            if end + _MESSAGE.size + length > size:
                break
            end += _MESSAGE.size + length
            file.seek(end)
    return end

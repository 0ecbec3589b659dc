"""Outputs that take their final name only when they are complete."""

from __future__ import annotations

import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from particlecli.errors import OutputError, UsageError

PARTIAL = ".partial"
"""What stands before the ending of a temporary name."""

_PROBE = bytes(4096)


def within(folder: Path, path: str) -> Path:
    """The place of an output inside the output folder; symbolic links are followed first.

    Raises:
        UsageError: the path leaves the folder, or is the folder itself.
    """
    root = folder.resolve()
    place = (root / path).resolve()
    if place == root or not place.is_relative_to(root):
        raise UsageError(
            f"the output {path!r} is not inside the output folder {folder}; "
            "choose the folder with -o and name outputs relative to it"
        )
    return place


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turns what the operating system refuses while `path` is written into an OutputError."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror or error}") from error


class Pending:
    """A file, or a folder, that is written under a temporary name beside its final one.

    Attributes:
        path: the final name.
        temporary: the name to write to; same folder and same ending.

    Args:
        path: the final name.
        folder: whether it is a folder.
        hidden: whether the temporary is hidden: it is of no use to anyone when the process is killed.
    """

    def __init__(self, path: Path, *, folder: bool = False, hidden: bool = True) -> None:
        self.path = path
        self.temporary = path.with_name(f"{'.' * hidden}{path.stem}.{secrets.token_hex(4)}{PARTIAL}{path.suffix}")
        self._is_folder = folder
        self._made: list[Path] = []

    def claim(self) -> None:
        """Makes the missing folders and the temporary, and so finds out whether writing is possible.

        Raises:
            OutputError: the place cannot be written, the disk is full, or a folder stands where a file
                should go (or the reverse).
        """
        if self.path.exists() and self.path.is_dir() != self._is_folder:
            found, wanted = ("file", "folder") if self._is_folder else ("folder", "file")
            raise OutputError(f"cannot write the {wanted} {self.path}: there is a {found} of that name")
        with writing(self.path):
            self._make_parents()
            if self._is_folder:
                self.temporary.mkdir()
                _probe(self.temporary / "probe")
                (self.temporary / "probe").unlink()
            else:
                _probe(self.temporary)

    def commit(self) -> None:
        """Gives the finished output its final name, in place of an older one."""
        with writing(self.path):
            if not (self._is_folder and self.path.exists()):
                self.temporary.replace(self.path)
                return
            older = self.temporary.with_suffix(".older")
            self.path.replace(older)
            self.temporary.replace(self.path)
            shutil.rmtree(older)

    def discard(self) -> None:
        """Removes the temporary and the folders made for it that are still empty."""
        if self._is_folder:
            shutil.rmtree(self.temporary, ignore_errors=True)
        else:
            with suppress(OSError):
                self.temporary.unlink(missing_ok=True)
        with suppress(OSError):
            for parent in reversed(self._made):
                parent.rmdir()

    def _make_parents(self) -> None:
        missing = [parent for parent in self.path.parents if not parent.exists()]
        for parent in reversed(missing):
            parent.mkdir()
            self._made.append(parent)


def _probe(path: Path) -> None:
    """Writes a few bytes and empties the file again: a full disk still lets empty files be made."""
    path.write_bytes(_PROBE)
    path.write_bytes(b"")

"""Reading the scene that a command is given."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from particlecli.errors import UsageError

if TYPE_CHECKING:
    from particlecli.scene.model import Scene

_PATTERNS = ("*.yaml", "*.yml")


def load(path: Path, overrides: Sequence[str] | None = None) -> Scene:
    """Reads a scene.

    Raises:
        SceneError: it cannot be read or does not mean anything.
        UsageError: there is no such file; names scenes that are called alike.
    """
    if not path.exists():
        raise UsageError(f"{path}: no such file{_did_you_mean(path)}")
    from particlecli.scene.load import load_scene

    return load_scene(path, overrides or ())


def _did_you_mean(path: Path) -> str:
    folders = dict.fromkeys((path.parent, Path(), Path("scenes")))
    near = [scene for folder in folders for pattern in _PATTERNS for scene in folder.glob(pattern)]
    stems = get_close_matches(path.stem, sorted({scene.stem for scene in near}), n=3, cutoff=0.5)
    found = [str(scene) for stem in stems for scene in near if scene.stem == stem]
    return f"; did you mean {' or '.join(dict.fromkeys(found))}?" if found else ""

"""Scene files: reading them, with every problem located, and writing them with all defaults filled in."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from pathlib import Path

from pydantic import ValidationError

from particlecli.errors import Problem, SceneError
from particlecli.scene import checks, messages
from particlecli.scene.document import Node, Place
from particlecli.scene.dump import dump_scene
from particlecli.scene.model import Scene
from particlecli.scene.origin import Origin
from particlecli.scene.overrides import override
from particlecli.scene.reader import LONGEST, DocumentError, parse

__all__ = ["dump_scene", "load_scene"]

MOST_PROBLEMS = 100
"""Problems that are told one by one; of more than these, only the number."""

Found = list[tuple[Place, Problem]]


def load_scene(path: Path | str, overrides: Sequence[str] = ()) -> Scene:
    """Read a scene file.

    Args:
        path: the file; files that the scene names are looked for in its folder.
        overrides: `dotted.key=yaml value`, each put into the scene before it is validated.

    Raises:
        SceneError: the file cannot be read or is no valid scene; has all problems in the order of the file.
    """
    source = Path(path)
    try:
        root, problems = parse(_read(source))
    except DocumentError as error:
        raise SceneError([error.problem], path) from None
    if root is None or root.value is None:
        message = "is empty; a scene has at least a duration, and particles or emitters"
        raise SceneError([Problem("", message)], path)
    if not isinstance(root.value, dict):
        message = f"must be a mapping of keys such as duration:, not {messages.shown(root.value)}"
        raise SceneError([Problem("", message, root.place.line, root.place.column)], path)
    found = [(Place(each.line, each.column, each.option), each) for each in problems]
    scene = _build(root, source, overrides, found)
    if found or scene is None:
        raise SceneError(_in_order(found), path)
    return scene


def _build(root: Node, source: Path, changes: Sequence[str], found: Found) -> Scene | None:
    """The scene in a document; problems are added to `found`."""
    for change in changes:
        found += [(Place(option=each.option), each) for each in override(root, change)]
    try:
        scene = Scene.model_validate(root.plain())
    except ValidationError as error:
        found += messages.from_validation(error, root)
        return None
    scene._origin = Origin(str(source), source.parent, root)
    for location, message in checks.problems(scene):
        place = root.locate(location)
        found.append((place, messages.problem(location, message, place)))
    return scene


def _in_order(found: Found) -> list[Problem]:
    problems = [problem for _, problem in sorted(found, key=lambda each: each[0].order)]
    rest = len(problems) - MOST_PROBLEMS
    return [*problems[:MOST_PROBLEMS], Problem("", f"and {rest} more problems")] if rest > 0 else problems


def _read(path: Path) -> str:
    # A character of UTF-8 has four bytes at most, and what is longer is refused by its characters.
    try:
        with path.open("rb") as file:
            content = file.read(4 * LONGEST + 1)
        return content.decode("utf-8-sig")
    except FileNotFoundError:
        message = f"there is no such file{_similar(path)}"
    except IsADirectoryError:
        message = "is a folder; name the scene file in it"
    except UnicodeDecodeError:
        message = "is not a text file"
    except (OSError, ValueError) as error:
        message = f"cannot be read: {getattr(error, 'strerror', None) or error}"
    raise SceneError([Problem("", message)], path)


def _similar(path: Path) -> str:
    try:
        beside = [each.name for each in path.parent.iterdir() if each.suffix in (".yaml", ".yml")]
    except OSError:
        return ""
    nearest = difflib.get_close_matches(path.name, beside, 1)
    return f'; did you mean "{path.with_name(nearest[0])}"?' if nearest else ""

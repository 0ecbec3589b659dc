"""A scene that can be taken elsewhere: with copies of the data files it reads from its own folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from particlecli.scene.model import Scene


@dataclass(frozen=True)
class Attachment:
    """A data file of a scene.

    Attributes:
        source: where it is.
        name: where the portable scene looks for it, relative to its own folder.
    """

    source: Path
    name: str


def portable(scene: Scene, folder: str) -> tuple[Scene, tuple[Attachment, ...]]:
    """The scene with its files in `<folder>/`, named after the first groups that read them, and which these are."""
    attachments: dict[str, Attachment] = {}

    def carried(file: str, stem: str) -> str:
        name = f"{folder}/{stem}{Path(file).suffix}"
        return attachments.setdefault(file, Attachment(scene.folder / file, name)).name

    particles = {
        group: spec if spec.file is None else spec.model_copy(update={"file": carried(spec.file, group)})
        for group, spec in scene.particles.items()
    }
    looks = {
        group: look if look.image is None else look.model_copy(update={"sheet": carried(look.image, f"{group}-sheet")})
        for group, look in scene.look.groups.items()
    }
    look = scene.look.model_copy(update={"groups": looks})
    return scene.model_copy(update={"particles": particles, "look": look}), tuple(attachments.values())

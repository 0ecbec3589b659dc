"""The records of a run: the resolved scene and the report, written beside its outputs."""

from __future__ import annotations

import shutil
from pathlib import Path

from particlecli.report import Report
from particlecli.scene.load import dump_scene
from particlecli.scene.model import Scene
from particlecli.scene.portable import portable
from particlecli.sinks.pending import Pending, within, writing


class Records:
    """What it takes to make a picture again: `<name>.scene.yaml` and `<name>.report.json`.

    Data files, which a scene reads from its own folder, are copied to `<name>.files/`, where the resolved
    scene finds them.
    """

    def __init__(self, scene: Scene, folder: Path, name: str) -> None:
        self._resolved, attachments = portable(scene, f"{name}.files")
        self._copies = [(each.source, Pending(within(folder, each.name))) for each in attachments]
        self._scene_file = Pending(within(folder, f"{name}.scene.yaml"))
        self._report_file = Pending(within(folder, f"{name}.report.json"))

    @property
    def files(self) -> tuple[Path, ...]:
        """Final names of all of them."""
        return tuple(pending.path for pending in self._pending())

    def open(self) -> None:
        """Claims the names; raises OutputError when they cannot be written."""
        for pending in self._pending():
            pending.claim()

    def write(self, report: Report) -> None:
        """Writes them all and gives them their names."""
        for source, copy in self._copies:
            with writing(copy.path):
                shutil.copyfile(source, copy.temporary)
        with writing(self._scene_file.path):
            self._scene_file.temporary.write_text(dump_scene(self._resolved), encoding="utf-8")
        with writing(self._report_file.path):
            self._report_file.temporary.write_text(report.to_json() + "\n", encoding="utf-8")
        for pending in self._pending():
            pending.commit()

    def abort(self) -> None:
        """Removes what was begun."""
        for pending in self._pending():
            pending.discard()

    def _pending(self) -> tuple[Pending, ...]:
        return (*(copy for _, copy in self._copies), self._scene_file, self._report_file)

"""ForceModel: what all forces share."""

from __future__ import annotations

from typing import ClassVar

from particlecli.scene.types import Name, SceneModel, described


class ForceModel(SceneModel):
    """What all forces share: whom they act on."""

    uses_mass: ClassVar[bool] = False
    """Whether the acceleration depends on the particle's mass."""

    on: tuple[Name, ...] | None = described("groups it acts on; none: every newtonian group", default=None)

    @property
    def depends_on_velocity(self) -> bool:
        """Whether the force depends on the particle's velocity."""
        return False

    def acts_on(self, group: str) -> bool:
        """Whether it acts on a newtonian group of this name."""
        return self.on is None or group in self.on

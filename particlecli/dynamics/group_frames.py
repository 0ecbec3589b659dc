"""The state of one group as plain arrays."""

from __future__ import annotations

import numpy as np

from particlecli.dynamics.group import Group
from particlecli.frame import Floats, GroupFrame
from particlecli.scene.distributions import Distribution
from particlecli.scene.groups import Emitter, Particles

OPTIONAL_FIELDS = frozenset({"velocities", "ages", "lifetimes", "temperatures"})

_FIELDS = {
    "u": "velocities", "v": "velocities", "w": "velocities", "age": "ages", "lifetime": "lifetimes",
    "temperature": "temperatures",
}  # fmt: skip
"""Which optional field of a frame a component belongs to."""


def frame_of(group: Group, lifetime: float | Distribution | None, time: float, fields: frozenset[str]) -> GroupFrame:
    """The particles of a group, a copy.

    Args:
        group: the group.
        lifetime: of its particles as the scene has it, s.
        time: now, s.
        fields: the optional arrays wanted.
    """
    state = group.state
    names = ("x", "y", "z", *(each for each, field in _FIELDS.items() if field in fields and group.has(each)))
    block = state.read(names)
    rows: dict[str, Floats] = dict(zip(names, block, strict=True))

    def row(each: str, otherwise: float | None) -> Floats | None:
        if _FIELDS[each] not in fields or (each not in rows and otherwise is None):
            return None
        return rows[each] if each in rows else np.full(state.count, otherwise, dtype=state.real_dtype)

    return GroupFrame(
        ids=state.read(("id",))[0].astype(np.int64) if group.has("id") else np.arange(state.count),
        positions=block[:3].T,
        velocities=block[3:6].T if "u" in rows else None,
        ages=row("age", time),
        lifetimes=row("lifetime", lifetime if isinstance(lifetime, int | float) else None),
        temperatures=row("temperature", None),
    )


def frame_of_nobody(group: Particles | Emitter, fields: frozenset[str]) -> GroupFrame:
    """The frame of a group into which no particle is ever born: every array is there, of no rows."""

    def row(name: str, exists: bool) -> Floats | None:
        return np.empty(0, np.float32) if exists and name in fields else None

    moving = group.motion == "newtonian" and "velocities" in fields
    return GroupFrame(
        ids=np.empty(0, np.int64),
        positions=np.empty((0, 3), np.float32),
        velocities=np.empty((0, 3), np.float32) if moving else None,
        ages=row("ages", True),
        lifetimes=row("lifetimes", group.lifetime is not None),
        temperatures=row("temperatures", group.temperature is not None),
    )

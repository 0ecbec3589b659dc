"""Scenes of a few words and frames made by hand, without a simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from particlecli.frame import Frame, GroupFrame
from particlecli.scene.model import Scene

LEVEL = {"position": [0, 0, 4], "look_at": [0, 0, 0], "field_of_view": 40}
"""Looks along −z at the origin."""


def scene(
    *groups: str,
    size: tuple[int, int] = (64, 48),
    camera: Mapping[str, Any] = LEVEL,
    planes: Sequence[Mapping[str, Any]] = (),
    frames: Mapping[str, Any] | None = None,
    **look: Any,
) -> Scene:
    """A scene whose groups (default: one, "dust") are painted by the keyword arguments of the same names."""
    names = groups or ("dust",)
    styles = {name: look.pop(name) for name in names if name in look}
    return Scene.model_validate(
        {
            "duration": 1,
            "fps": 30,
            "particles": {name: {"positions": [[0, 0, 0]]} for name in names},
            "camera": {**camera, "resolution": size},
            "planes": list(planes),
            "frames": frames or {},
            "look": {"bloom": 0, **look, "groups": styles},
        }
    )


def group(
    positions: ArrayLike,
    *,
    dtype: type[np.floating[Any]] = np.float32,
    ids: ArrayLike | None = None,
    **fields: ArrayLike,
) -> GroupFrame:
    """Particles stored as the engine stores them: component by component."""

    def stored(values: ArrayLike) -> NDArray[np.floating[Any]]:
        return np.ascontiguousarray(np.asarray(values, dtype).T).T

    places = stored(positions)
    numbers = np.arange(len(places)) if ids is None else np.asarray(ids)
    return GroupFrame(
        ids=numbers.astype(np.int64),
        positions=places,
        **{name: stored(values) for name, values in fields.items()},
    )


def frame(**groups: GroupFrame) -> Frame:
    return Frame(index=0, time=0.0, groups=groups)


def centroid(light: NDArray[np.floating[Any]]) -> tuple[float, float]:
    """Mean place of the light of all three primaries together, pixels."""
    total = light.astype(np.float64).sum(axis=-1)
    rows, columns = np.indices(total.shape)
    return float((total * columns).sum() / total.sum()), float((total * rows).sum() / total.sum())

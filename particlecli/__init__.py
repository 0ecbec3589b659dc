"""Declarative particle dynamics: YAML scenes in, pictures, video and recordings out.

    from particlecli import load_scene, run, simulate

    scene = load_scene("campfire.yaml")
    for frame in simulate(scene):
        print(frame.time, frame.groups["sparks"].positions.mean(axis=0))
    run(scene)

The names are imported when they are first used, so that `import particlecli` costs nothing.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from particlecli.accuracy.simulate import simulate
    from particlecli.frame import Frame
    from particlecli.run import RunOptions, run
    from particlecli.scene.load import load_scene

__version__ = "0.1.0"

__all__ = ["Frame", "RunOptions", "__version__", "load_scene", "run", "simulate"]

_HOMES = {
    "Frame": "particlecli.frame",
    "RunOptions": "particlecli.run",
    "load_scene": "particlecli.scene.load",
    "run": "particlecli.run",
    "simulate": "particlecli.accuracy.simulate",
}


def __getattr__(name: str) -> Any:
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module 'particlecli' has no attribute {name!r}")
    value = getattr(import_module(home), name)
    globals()[name] = value
    return value


class _Package(ModuleType):
    """Keeps `run` and `simulate` the functions: importing a submodule would put the module in their place."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _HOMES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package

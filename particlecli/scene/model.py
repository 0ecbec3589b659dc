"""Scene: the whole of a scene file."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import PrivateAttr

from particlecli.errors import SceneError
from particlecli.scene.camera import Camera
from particlecli.scene.flows import FlowTerm
from particlecli.scene.forces import Force
from particlecli.scene.frames import CoordinateFrame
from particlecli.scene.groups import Emitter, Particles
from particlecli.scene.integrator import Integrator
from particlecli.scene.known_answers import KnownAnswer
from particlecli.scene.look import Look
from particlecli.scene.origin import Origin
from particlecli.scene.outputs import Output
from particlecli.scene.planes import Plane
from particlecli.scene.types import Name, Positive, SceneModel, Whole, described


class Scene(SceneModel):
    """A scene. SI units, right-handed axes, y up."""

    title: str = described("what the scene shows", default="")
    seed: Whole = described("another number, other random draws", default=0, ge=0, lt=2**64)
    duration: Positive = described("how long it lasts, s")
    fps: Positive = described("frames a second", default=30.0)
    precision: Literal["single", "double"] = described("of the simulation's numbers: 32 or 64 bits", default="single")
    flows: dict[Name, tuple[FlowTerm, ...]] = described("named velocity fields; terms add up", default={})
    frames: dict[Name, CoordinateFrame] = described("named coordinate frames, a tree", default={})
    particles: dict[Name, Particles] = described("groups that are there at t = 0", default={})
    emitters: dict[Name, Emitter] = described("groups that are born over time", default={})
    forces: tuple[Force, ...] = described("what acts on the newtonian groups", default=())
    planes: tuple[Plane, ...] = described("what particles bounce off", default=())
    integrator: Integrator = described("scheme and step", default=Integrator())
    reference: tuple[KnownAnswer, ...] = described("what is known of the result; `check` compares it", default=())
    camera: Camera = described("the view", default=Camera())
    look: Look = described("how frames look", default=Look())
    outputs: tuple[Output, ...] = described("what `run` writes when the command line does not say", default=())

    _origin: Origin = PrivateAttr(default=Origin())

    @property
    def folder(self) -> Path:
        """The folder of the scene file; files that the scene names are read from here."""
        return self._origin.folder

    @property
    def name(self) -> str:
        """The name of the scene file without its ending; "scene" for a scene made in Python."""
        return Path(self._origin.source).stem or "scene"

    def located(self, error: SceneError) -> SceneError:
        """The error with the places in the scene's file of the keys that its problems are about."""
        problems = [self._origin.located(problem) for problem in error.problems]
        return SceneError(problems, self._origin.source or error.source)

    @property
    def groups(self) -> dict[str, Particles | Emitter]:
        """All groups by name, in the order in which they are simulated and drawn."""
        return {**self.particles, **self.emitters}

    @property
    def frame_count(self) -> int:
        """Number of frames, the one at t = 0 included."""
        return round(self.duration * self.fps) + 1

"""Report: what a run did, how long each phase took and which files it left."""

from __future__ import annotations

import json
import platform
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from particlecli import __version__

if TYPE_CHECKING:
    from particlecli.accuracy.estimate import GroupError
    from particlecli.auto.outcome import Choice
    from particlecli.scene.integrator import ContactScheme

_LIBRARIES = ("taichi", "numpy")


@dataclass(frozen=True)
class Phases:
    """Wall time of the run by what it waited for, s; together they make up nearly all of `wall_s`.

    Attributes:
        choose_s: flying pilots for `auto`, compiling them included.
        compile_s: starting Taichi, building the system and compiling its kernels.
        simulate_s: advancing particles.
        estimate_s: carrying a sample of them again, to estimate the error.
        render_s: making pictures of frames, compiling the renderer included.
        encode_s: waiting for encoders and disks; what they do beside the simulation costs nothing.
        wall_s: the whole run.
    """

    choose_s: float
    compile_s: float
    simulate_s: float
    estimate_s: float
    render_s: float
    encode_s: float
    wall_s: float


@dataclass(frozen=True)
class Report:
    """What a run did.

    Attributes:
        title, seed, duration, fps, precision: as in the scene; s, frames a second.
        integrator, step_s: scheme, and its step, s; none where it chooses its steps.
        choice: what `auto` chose, what it did not, and why; none where the scene has a scheme.
        quality: "draft" or "final".
        resolution: width and height of the pictures, pixels; none when no pictures were made.
        threads: worker threads; none: one a core.
        frames: how many frames were simulated.
        alive: particles alive at the end.
        births: by group.
        deaths: by group and cause.
        estimated_error: of positions, by group, see `GroupError`; a group of which nothing was compared is not there.
        not_estimated: groups of which that would have cost too large a share of the run, or that are too many together.
        impacts: by group that meets planes: "located" at their instants, or at the "end_of_step".
        conserved: by quantity that the forces between particles keep, how far it drifted, see `Conserved`.
        particle_steps: steps taken, summed over all particles.
        particle_steps_per_second: while simulating.
        bytes_per_particle: bytes of state that a particle takes, by group.
        memory: bytes of state in all.
        phases: wall time.
        files: what was written, the resolved scene and this report included.
        versions: of particlecli, Python and the libraries that numbers depend on.
    """

    title: str
    seed: int
    duration: float
    fps: float
    precision: str
    integrator: str
    step_s: float | None
    choice: Choice | None
    quality: str
    resolution: tuple[int, int] | None
    threads: int | None
    frames: int
    alive: int
    births: dict[str, int]
    deaths: dict[str, dict[str, int]]
    estimated_error: dict[str, GroupError]
    not_estimated: tuple[str, ...]
    impacts: dict[str, ContactScheme]
    conserved: dict[str, float]
    particle_steps: int
    particle_steps_per_second: float
    bytes_per_particle: dict[str, int]
    memory: int
    phases: Phases
    files: tuple[str, ...]
    versions: dict[str, str]

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries, lists, strings and numbers."""
        return asdict(self)

    def to_json(self) -> str:
        """One JSON object, indented."""
        return json.dumps(self.to_dict(), indent=2, ensure_ascii=False)


def versions() -> dict[str, str]:
    """Versions of particlecli, Python and the libraries that numbers depend on."""
    libraries = {name: version(name) for name in _LIBRARIES}
    return {"particlecli": __version__, "python": platform.python_version(), **libraries}

"""An independent judge: a scene's run against SciPy's DOP853 in double precision, in metres and in pixels."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from particlecli import runtime
from particlecli.accuracy.bodies import CannotJudgeError, Doubles
from particlecli.accuracy.refusal import refuse_unstable
from particlecli.dynamics.births import ParticleBirths
from particlecli.dynamics.plan import Plan, make_plan
from particlecli.frame import Frame
from particlecli.render.camera import views_of
from particlecli.scene.forces import (
    Drag,
    ForceField,
    Gravity,
    OrbitForce,
    PointGravity,
    QuadraticDrag,
    VortexForce,
)
from particlecli.scene.model import Scene
from particlecli.simulate import Simulation

__all__ = ["CannotJudgeError", "Deviation", "Judgement", "judge"]

Ids = NDArray[np.int64]
Places = dict[str, tuple[Ids, Doubles]]
"""By group, numbers and positions, m, shape (n, 3), of particles at an instant."""

Show = Callable[[int, int], None]

MOST_PARTICLE_FRAMES = 2_000_000
"""Particles times frames that SciPy follows in minutes."""

ON_EACH_ALONE = (Gravity, PointGravity, Drag, QuadraticDrag, ForceField, VortexForce, OrbitForce)
"""Forces that act on each particle alone, so that particles can be followed one by one."""


@dataclass(frozen=True)
class Deviation:
    """How far particles of a group are from where they should be, at one frame or at all of them.

    Attributes:
        metres: largest distance.
        pixels: largest distance on the picture, of particles that are seen on it; none if none is.
        particle, time: which is furthest off in metres, and when, s.
    """

    metres: float
    pixels: float | None
    particle: int
    time: float

    def or_larger(self, other: Deviation | None) -> Deviation:
        """The largest of two."""
        if other is None:
            return self
        further = max(self, other, key=lambda each: each.metres)
        pixels = max((each.pixels for each in (self, other) if each.pixels is not None), default=None)
        return Deviation(further.metres, pixels, further.particle, further.time)


@dataclass(frozen=True)
class Judgement:
    """A group's run against the judge's.

    Attributes:
        group: its name.
        compared: particles compared, summed over all frames.
        final: at the last frame; none where nothing was there to compare.
        largest: over all frames.
        outlived: particles that lived on in the run though a plane had killed them.
    """

    group: str
    compared: int
    final: Deviation | None
    largest: Deviation | None
    outlived: int


def judge(scene: Scene, *, threads: int | None = None, show: Show | None = None) -> list[Judgement]:
    """Run a scene, follow its particles once more with SciPy in double precision, and compare the frames.

    Births and impacts are followed at their exact instants, and particles as long as they live in the run. Children
    and what is fixed to a frame are not judged.

    Args:
        scene: the scene.
        threads: worker threads; none: one a core.
        show: is told how many frames SciPy has done, and how many particles it follows, after each.

    Raises:
        CannotJudgeError: the scene has something that cannot be followed, or too many particles; says what.
        SceneError, SimulationError: as `simulate`.
    """
    plan = make_plan(scene.model_copy(update={"precision": "double"}))
    coupled = _coupled(plan)
    _refuse(plan)
    fields = dict.fromkeys(scene.groups, frozenset[str]())
    judged = plan.parentless
    simulation = Simulation(scene, threads=threads, fields=fields)
    refuse_unstable(simulation)
    run = [_places(frame, judged) for frame in simulation]
    runtime.start("double", threads)
    truth = _follow_all(plan, run) if coupled else _follow_each(plan, run)
    tally = _Tally(scene, judged)
    for index, (found, right) in enumerate(zip(run, truth, strict=True)):
        tally.add(index, found, right)
        if show is not None:
            show(index + 1, sum(len(ids) for ids, _ in right.values()))
    return tally.judgements()


class _Tally:
    """Deviations of all groups, gathered frame by frame."""

    def __init__(self, scene: Scene, groups: list[str]) -> None:
        self._scene = scene
        self._groups = groups
        self._view_at = views_of(scene.camera, *scene.camera.resolution, scene.frames)
        self._compared = dict.fromkeys(groups, 0)
        self._final: dict[str, Deviation | None] = dict.fromkeys(groups)
        self._largest: dict[str, Deviation | None] = dict.fromkeys(groups)
        self._outlived: dict[str, set[int]] = {name: set() for name in groups}

    def add(self, index: int, found: Places, right: Places) -> None:
        """Compares a frame."""
        for group, (ids, positions) in found.items():
            true_ids, true_positions = right.get(group, (ids[:0], positions[:0]))
            both = np.isin(ids, true_ids)
            self._outlived[group].update(ids[~both].tolist())
            self._compared[group] += len(true_ids)
            self._final[group] = None
            if len(true_ids):
                time = index / self._scene.fps
                deviation = self._deviation(time, true_ids, positions[both], true_positions)
                self._final[group] = deviation
                self._largest[group] = deviation.or_larger(self._largest[group])

    def _deviation(self, time: float, ids: Ids, found: Doubles, right: Doubles) -> Deviation:
        metres = np.linalg.norm(found - right, axis=1)
        worst = int(np.argmax(metres))
        view = self._view_at(time)
        here, depth = view.project(right)
        there, _ = view.project(found)
        half = np.array([view.width, view.height]) / 2
        seen = (depth > 0) & (np.abs(here - view.center) <= half).all(axis=1)
        pixels = np.linalg.norm(here - there, axis=1)[seen]
        largest = float(np.nan_to_num(pixels, nan=np.inf).max()) if len(pixels) else None
        return Deviation(float(metres[worst]), largest, int(ids[worst]), time)

    def judgements(self) -> list[Judgement]:
        """What came out for each group."""
        return [
            Judgement(name, self._compared[name], self._final[name], self._largest[name], len(self._outlived[name]))
            for name in self._groups
        ]


def _places(frame: Frame, groups: list[str]) -> Places:
    return {name: (frame.groups[name].ids.copy(), frame.groups[name].positions.astype(np.float64)) for name in groups}


def _coupled(plan: Plan) -> bool:
    """Whether particles act on each other; refuses if they then also come, go or meet planes."""
    force = next((force for force in plan.scene.forces if not isinstance(force, ON_EACH_ALONE)), None)
    if force is not None and not all(
        isinstance(group.births, ParticleBirths) and not group.planes and "fate" not in group.components
        for group in plan.groups
    ):
        raise CannotJudgeError(
            f"{force.type} couples particles; the judge follows that only without births, deaths and planes"
        )
    return force is not None


def _refuse(plan: Plan) -> None:
    if any(plane.frame is not None for plane in plan.scene.planes):
        raise CannotJudgeError("planes that ride on coordinate frames cannot be followed by the judge")
    size = sum(group.capacity for group in plan.groups) * plan.scene.frame_count
    if size > MOST_PARTICLE_FRAMES:
        raise CannotJudgeError(
            f"up to {size:,} particles × frames are too many for SciPy, which follows "
            f"{MOST_PARTICLE_FRAMES:,}; it can judge fewer of either, as in --set duration=1"
        )


def _follow_all(plan: Plan, run: list[Places]) -> Iterator[Places]:
    from particlecli.accuracy.truth import SystemTruth
    from particlecli.dynamics.system import System

    truth = SystemTruth(System(plan))
    for index in range(len(run)):
        yield _places(truth.at(index / plan.scene.fps), plan.parentless)


def _follow_each(plan: Plan, run: list[Places]) -> Iterator[Places]:
    from particlecli.accuracy.truth import GroupTruth
    from particlecli.dynamics.probe import Probe
    from particlecli.dynamics.system import System

    system = System(plan)
    truths = {
        group.name: GroupTruth(group, Probe(system.groups[group.name].motion, "double"), 1 / plan.scene.fps)
        for group in plan.groups
        if group.name in plan.parentless
    }
    for index, frame in enumerate(run):
        yield {name: truth.advance(index / plan.scene.fps, frame[name][0]) for name, truth in truths.items()}

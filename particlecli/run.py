"""run(scene): one scene to its outputs and its report."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from particlecli import runtime
from particlecli.accuracy import prices
from particlecli.accuracy.conserved import Conserved
from particlecli.accuracy.estimate import ErrorEstimate
from particlecli.accuracy.observer import Observer
from particlecli.accuracy.refusal import refuse_unstable
from particlecli.accuracy.watch import Accuracy, Watch
from particlecli.errors import UsageError
from particlecli.records import Records
from particlecli.render.camera import views_of
from particlecli.report import Phases, Report, versions
from particlecli.scene.model import Scene
from particlecli.scene.outputs import Output, RecordingOutput, TrajectoryOutput, VideoOutput
from particlecli.simulate import Simulation
from particlecli.sinks.base import Sink
from particlecli.sinks.registry import make_sink

if TYPE_CHECKING:
    from particlecli.render.renderer import Renderer

Quality = Literal["draft", "final"]


@dataclass(frozen=True)
class RunOptions:
    """How to run a scene.

    Attributes:
        name: what the records and default outputs are called; none: like the scene file.
        folder: output folder; none: `outputs/<name>`.
        outputs: what to write instead of the scene's own outputs; empty: nothing at all, not even the report.
        quality: "final" as the scene says; "draft" with half the resolution and faster encoding.
        threads: worker threads; none: one a core. Results do not depend on it.
        estimate: whether to estimate the error at whatever cost, or not at all; none: at a small share of the run's.
    """

    name: str | None = None
    folder: Path | None = None
    outputs: tuple[Output, ...] | None = None
    quality: Quality = "final"
    threads: int | None = None
    estimate: bool | None = None


@dataclass(frozen=True)
class Progress:
    """How far a run is.

    Attributes:
        frames, frame_count: frames done, of how many.
        alive: particles alive now.
    """

    frames: int
    frame_count: int
    alive: int


class _Stopwatch:
    """Adds up the wall time spent inside its `with` blocks, s."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def __enter__(self) -> None:
        self._began = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self.seconds += time.perf_counter() - self._began


def run(
    scene: Scene,
    options: RunOptions | None = None,
    progress: Callable[[Progress], None] | None = None,
    notice: Callable[[str], None] | None = None,
) -> Report:
    """Simulates a scene, writes its outputs and, beside them, the resolved scene and the report.

    Every file takes its final name, replacing an older one, only when it is complete. On any error, and on
    Ctrl-C, what was begun is removed.

    Args:
        scene: what to run; without outputs of its own a video is made.
        options: how to run it.
        progress: called after each frame.
        notice: called with what is worth knowing before the simulation begins: what `auto` chose, and why.

    Raises:
        SceneError, SimulationError: the scene cannot be simulated, or not to its end; or its step is so long
            that the scheme would blow the motion up, see `refuse_unstable`.
        UsageError: an output path leaves the output folder, ends in no known format, or is used twice.
        OutputError: an output cannot be written; found out before simulating wherever possible.
    """
    return _Run(scene, options or RunOptions()).to_end(progress or (lambda _: None), notice or (lambda _: None))


class _Run:
    """One run: what it writes, and the time its phases take."""

    def __init__(self, scene: Scene, options: RunOptions) -> None:
        name = options.name or scene.name
        outputs = scene.outputs if options.outputs is None else options.outputs
        if options.outputs is None and not outputs:
            outputs = (VideoOutput(type="video", path=f"{name}.mp4"),)
        self.scene = scene.model_copy(update={"outputs": outputs})
        self.options = options
        self.began = time.perf_counter()
        self.starting, self.rendering, self.encoding, self.estimating = (_Stopwatch() for _ in range(4))
        draft = options.quality == "draft"
        width, height = scene.camera.resolution
        self.size = (max(16, width // 2), max(16, height // 2)) if draft else (width, height)
        self.folder = options.folder or Path("outputs") / name
        self.sinks = [make_sink(output, self.folder, self.scene, size=self.size, draft=draft) for output in outputs]
        self.records = Records(self.scene, self.folder, name) if outputs else None
        self._refuse_clashes()

    def to_end(self, progress: Callable[[Progress], None], notice: Callable[[str], None]) -> Report:
        with self._opened():
            with self.starting:
                runtime.start(self.scene.precision, self.options.threads)
            with self.rendering:
                renderer = self._renderer()
            fields = self._fields(renderer)
            simulation = Simulation(self.scene, threads=self.options.threads, fields=fields)
            for line in simulation.choice.lines() if simulation.choice else ():
                notice(line)
            with self.starting:
                refuse_unstable(simulation)
                observer = Observer(simulation) if self._observed else None
            with self.estimating:
                accuracy = self._accuracy(simulation)
            for frame in simulation:
                with self.estimating:
                    accuracy.watch(frame)
                with self.rendering:
                    image = renderer.render(frame) if renderer else None
                with self.encoding:
                    if observer:
                        frame = replace(frame, series=observer.series(frame), springs=observer.springs())
                    for sink in self.sinks:
                        sink.write(frame, image)
                progress(Progress(frame.index + 1, self.scene.frame_count, simulation.alive))
            with self.estimating:
                found = accuracy.result()
            told = self._report(simulation, found).to_json()
            with self.encoding:
                for sink in self.sinks:
                    sink.conclude(told, {name: error.over_time for name, error in found.errors.items()})
                    sink.close()
            report = self._report(simulation, found)
            if self.records:
                self.records.write(report)
        return report

    @contextmanager
    def _opened(self) -> Iterator[None]:
        """Opens all outputs, so that trouble shows before the work begins; cleans up after errors."""
        try:
            for each in self._written():
                each.open()
            yield
        except BaseException:
            for each in reversed(self._written()):  # the one that made the folder removes it when it is empty
                each.abort()
            raise

    def _accuracy(self, simulation: Simulation) -> Watch:
        """What tells of errors, within what the options allow."""
        if self.options.estimate is False:
            return Watch()
        size = self.size if self._pictured else None
        records = sum(isinstance(output, TrajectoryOutput | RecordingOutput) for output in self.scene.outputs)
        allowed = None if self.options.estimate else prices.besides(self.scene, size, records)
        conserved = Conserved(simulation, allowed)
        view_at = views_of(self.scene.camera, *self.size, self.scene.frames)
        return Watch(ErrorEstimate(simulation, view_at, allowed, conserved.price), conserved)

    @property
    def _pictured(self) -> bool:
        return any(sink.needs_image for sink in self.sinks)

    @property
    def _observed(self) -> bool:
        return any(sink.needs_series for sink in self.sinks)

    def _renderer(self) -> Renderer | None:
        if not self._pictured:
            return None
        from particlecli.render.renderer import Renderer

        return Renderer(self.scene, *self.size)

    def _fields(self, renderer: Renderer | None) -> dict[str, frozenset[str]]:
        """The optional arrays that frames must carry, by group."""
        readers: list[Sink | Renderer] = [*self.sinks, renderer] if renderer else [*self.sinks]
        observed = frozenset({"velocities"} if self._observed else ())
        return {name: observed.union(*(each.needs(name) for each in readers)) for name in self.scene.groups}

    def _written(self) -> list[Sink | Records]:
        return [*self.sinks, self.records] if self.records else [*self.sinks]

    def _files(self) -> list[Path]:
        return [file for each in self._written() for file in each.files]

    def _refuse_clashes(self) -> None:
        files = self._files()
        for index, file in enumerate(files):
            for other in files[index + 1 :]:
                if file == other or file in other.parents or other in file.parents:
                    raise UsageError(f"two outputs would write to {file}; give them different names")

    def _report(self, simulation: Simulation, found: Accuracy) -> Report:
        seconds = simulation.simulate_seconds
        root = self.folder.resolve()
        return Report(
            title=self.scene.title,
            seed=self.scene.seed,
            duration=self.scene.duration,
            fps=self.scene.fps,
            precision=self.scene.precision,
            integrator=simulation.scene.integrator.scheme,
            step_s=None if simulation.scene.integrator.adaptive else simulation.plan.step,
            choice=simulation.choice,
            quality=self.options.quality,
            resolution=self.size if self._pictured else None,
            threads=self.options.threads,
            frames=self.scene.frame_count,
            alive=simulation.alive,
            births=dict(simulation.births),
            deaths={group: dict(causes) for group, causes in simulation.deaths.items()},
            estimated_error=found.errors,
            not_estimated=found.left_out,
            impacts={group.name: group.impacts for group in simulation.plan.groups if group.impacts},
            conserved=found.drifts,
            particle_steps=simulation.particle_steps,
            particle_steps_per_second=simulation.particle_steps / seconds if seconds else 0.0,
            bytes_per_particle={group.name: group.bytes_per_particle for group in simulation.plan.groups},
            memory=simulation.plan.memory,
            phases=Phases(
                choose_s=simulation.choose_seconds,
                compile_s=self.starting.seconds + simulation.compile_seconds,
                simulate_s=seconds,
                estimate_s=self.estimating.seconds,
                render_s=self.rendering.seconds,
                encode_s=self.encoding.seconds,
                wall_s=time.perf_counter() - self.began,
            ),
            files=tuple(str(self.folder / file.relative_to(root)) for file in self._files()),
            versions=versions(),
        )

"""Error against time: integrators at many paces on one scene, each measured by a converged solution."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from particlecli import cores, runtime
from particlecli.accuracy.converged import converged
from particlecli.accuracy.curves import WorkPrecision, on_floor
from particlecli.accuracy.peers import PEERS, TOLERANCES, GaveUp, Peer, why_not
from particlecli.accuracy.runs import Run
from particlecli.accuracy.tracks import deviation
from particlecli.accuracy.trial import Pace, Trial, suitable, trial_plan
from particlecli.dynamics.plan import make_plan
from particlecli.dynamics.sampling import chosen
from particlecli.errors import SimulationError, UsageError
from particlecli.render.camera import View
from particlecli.runtime import Precision
from particlecli.scene.integrator import ADAPTIVE, Scheme
from particlecli.scene.model import Scene

COMPARED = 2000
"""Particles of each group whose errors are measured, at most."""

REPEATS = 7
"""How often a short run is timed."""

STEPS = tuple(2**n for n in range(20))
"""Steps a frame that are tried one after the other."""

SMALLEST_TOLERANCE = {"single": 1e-7, "double": 1e-15}

PATIENCE = 5.0
"""How much longer than one of our runs a peer may take."""

MOST_PARTICLES, MOST_PARTICLE_FRAMES = 20_000, 2_000_000
"""Births of each group that are simulated where the study does not say, and these times frames."""

FIRST: tuple[Scheme, ...] = ("exact", "rk4", "velocity_verlet", "dormand_prince", "midpoint", "dop853", "yoshida4")
"""Schemes that run before the others, after the scene's own, as time may not suffice for all."""

REFERENCE, DOUBLE, PEERED = 0.3, 0.7, 0.8
"""The parts of a study's time after which the reference, runs in double precision and peers are to be done."""

SOLUTIONS = 100.0
"""Frames of the scene's own scheme, in time, that a frame of the reference costs, where particles act on each other."""

LEAST = 2
"""Schemes that run in each precision whatever time it takes."""

FEWEST_FRAMES = 5
"""Frames that are looked at, at least."""


@dataclass(frozen=True)
class Study:
    """What to try.

    Attributes:
        integrators: schemes; none: all that suit the scene.
        steps: numbers of equal steps in a frame; none: doubled until it no longer pays.
        tolerances: for adaptive schemes; none: a tenth of the last until it no longer pays.
        particles: births of each group that are simulated, at most; none: as many as suit the number of frames.
        budget: wall time, s, that all may take, about; integrators that it does not suffice for are left out, and of
            scenes whose particles act on each other the first frames alone may be looked at.
        longest: wall time, s, that a run may take, about, where steps and tolerances are not given.
        peers: whether SciPy's integrators run too.
        threads: worker threads; none: one a core.
    """

    integrators: tuple[Scheme, ...] | None = None
    steps: tuple[int, ...] | None = None
    tolerances: tuple[float, ...] | None = None
    particles: int | None = None
    budget: float = 120.0
    longest: float = 1.0
    peers: bool = True
    threads: int | None = None


Progress = Callable[[str], None]
"""Told what is being tried."""


def work_precision(scene: Scene, study: Study | None = None, progress: Progress = lambda _: None) -> WorkPrecision:
    """Run a scene with integrators at many paces, in double precision and in its own.

    Raises:
        UsageError: an integrator does not suit the scene, or it has a single frame.
        SimulationError: there is nothing to measure errors by.
    """
    return _Bench(scene, study or Study(), progress).result()


class _Bench:
    """The trials of a study, one after the other."""

    def __init__(self, scene: Scene, study: Study, progress: Progress) -> None:
        if scene.frame_count < 2:
            raise UsageError("the scene ends before its second frame: there is nothing to measure")
        self._scene, self._study, self._progress = scene, study, progress
        self._suitable = suitable(scene)
        self._schemes = _in_order(scene, self._suitable) if study.integrators is None else study.integrators
        for scheme in self._schemes:
            if scheme not in self._suitable:
                raise UsageError(f"{scheme} cannot run this scene; {', '.join(self._suitable)} can")
        fitting = max(1, MOST_PARTICLE_FRAMES // scene.frame_count)
        self._particles = min(MOST_PARTICLES, fitting) if study.particles is None else study.particles
        self._view = View.of(scene.camera, *scene.camera.resolution, scene.frames)
        self._double: dict[Scheme, Trial] = {}
        self._left_out: list[str] = []

    def result(self) -> WorkPrecision:
        study = self._study
        self._began = time.perf_counter()
        runtime.start("double", study.threads)
        self._progress("reference")
        whole = make_plan(self._scene)
        total = self._scene.frame_count
        if any(group.coupled for group in whole.groups):
            self._shorten()
        longest = min(2 * study.longest, REFERENCE * study.budget / 4)
        self._reference = converged(self._in_double, self._suitable, self._view, longest)
        runs = self._runs(self._schemes, "double", DOUBLE)
        plan = self._in_double("dop853").plan
        particles = {
            some.name: (some.births.total, group.births.total)
            for some, group in zip(plan.groups, whole.groups, strict=True)
        }
        no_peers = why_not(plan) if study.peers else "not asked for"
        if not no_peers:
            runs += [run for name in PEERS for run in self._peer(name)]
        if self._scene.precision == "single":
            self._double.clear()
            runtime.start("single", study.threads)
            runs += self._runs(self._schemes, "single", 1.0)
        return WorkPrecision(
            scene=self._scene,
            particles=particles,
            reference=self._reference,
            runs=tuple(runs),
            no_peers=no_peers,
            threads=study.threads or cores.usable(),
            frames_of=total,
            left_out=tuple(self._left_out),
            seconds=time.perf_counter() - self._began,
        )

    def _shorten(self) -> None:
        """Look at so many frames alone as there is time for, of a scene whose particles cannot be thinned."""
        scene = self._scene
        own = scene.integrator.type if scene.integrator.type in self._suitable else "dormand_prince"
        pace = (
            Pace(tolerance=scene.integrator.local_tolerance)
            if own in ADAPTIVE
            else Pace(make_plan(scene).steps_per_frame)
        )
        few = scene.model_copy(update={"duration": min(scene.duration, FEWEST_FRAMES / scene.fps)})
        trial = self._in_double(own)
        spent = trial.shortened(few).run(pace, repeats=2).seconds / max(1, few.frame_count - 1)
        frames = max(FEWEST_FRAMES, int(REFERENCE * self._study.budget / (SOLUTIONS * spent)))
        if frames < scene.frame_count - 1:
            self._scene = scene.model_copy(update={"duration": frames / scene.fps})
            self._double[own] = trial.shortened(self._scene)

    def _runs(self, schemes: Sequence[Scheme], precision: Precision, share: float) -> list[Run]:
        """The runs of schemes, until so much of the time has passed."""
        runs: list[Run] = []
        for number, scheme in enumerate(schemes):
            if number >= LEAST and time.perf_counter() - self._began > share * self._study.budget:
                self._left_out += [f"{each} ({precision})" for each in schemes[number:]]
                break
            runs += self._climb(scheme, precision)
        return runs

    def _trial(self, scheme: Scheme, precision: Precision) -> Trial:
        plan = trial_plan(self._scene, scheme, precision, self._particles)
        return Trial(plan, {group.name: chosen(group.births, COMPARED) for group in plan.groups})

    def _in_double(self, scheme: Scheme) -> Trial:
        if scheme not in self._double:
            self._double[scheme] = self._trial(scheme, "double")
        return self._double[scheme]

    def _climb(self, scheme: Scheme, precision: Precision) -> list[Run]:
        """The runs of a scheme from few steps to many."""
        trial = self._in_double(scheme) if precision == "double" else self._trial(scheme, precision)
        climbed: list[Run] = []
        for pace in self._paces(scheme, precision):
            run = self._run(trial, scheme, precision, pace)
            self._progress(f"{scheme}, {precision} precision, {run.pace}")
            if (self._study.tolerances if scheme in ADAPTIVE else self._study.steps) is not None:
                climbed.append(run)
                continue
            if climbed and run.deviation is not None and run.evaluations == climbed[-1].evaluations:
                climbed.pop()  # frames alone limit the steps: the smaller tolerance is had for nothing
            climbed.append(run)
            if self._pays_no_more(climbed):
                break
        return climbed

    def _paces(self, scheme: Scheme, precision: Precision) -> Iterator[Pace]:
        if scheme in ADAPTIVE:
            smallest = SMALLEST_TOLERANCE[precision]
            powers = [10.0**-n for n in range(1, 16) if 10.0**-n >= smallest]
            yield from (Pace(tolerance=tolerance) for tolerance in self._study.tolerances or powers)
        else:
            yield from (Pace(steps=steps) for steps in self._study.steps or STEPS)

    def _pays_no_more(self, climbed: list[Run]) -> bool:
        """Whether further runs would take too long, or could not be told from a perfect one."""
        last = climbed[-1]
        known = self._reference.uncertainty.worst.p95
        arrived = [run for run in climbed if run.error <= self._reference.extent]
        return (
            last.seconds > self._study.longest
            or last.error < 2 * known
            or on_floor(arrived, self._reference.extent)
            or (last.deviation is None and bool(arrived))
        )

    def _run(self, trial: Trial, scheme: Scheme, precision: Precision, pace: Pace) -> Run:
        step = None if pace.steps is None else 1.0 / self._scene.fps / pace.steps
        run = Run(scheme, precision, pace.steps, step, pace.tolerance)
        began = time.perf_counter()
        try:
            outcome = trial.run(pace, repeats=REPEATS)
            return replace(
                run,
                deviation=deviation(outcome.tracks, self._reference.tracks, self._view),
                energy_drift=outcome.energy_drift,
                seconds=outcome.seconds,
                evaluations=outcome.evaluations,
                particle_steps=outcome.particle_steps,
            )
        except SimulationError as error:
            return replace(run, seconds=time.perf_counter() - began, trouble=str(error))

    def _peer(self, name: str) -> list[Run]:
        """The runs of one of SciPy's integrators, from large tolerances to small."""
        system = self._in_double("dop853").system
        left = PEERED * self._study.budget - (time.perf_counter() - self._began)
        limit = min(PATIENCE * self._study.longest, left / len(PEERS))
        if limit <= 0.0:
            self._left_out.append(name)
            return []
        peer = Peer(name, system, self._reference.tracks, limit)
        runs: list[Run] = []
        for tolerance in self._study.tolerances or TOLERANCES:
            run = Run(name, "double", None, None, tolerance, peer=True)
            self._progress(f"{name}, {run.pace}")
            try:
                outcome = peer.run(tolerance)
            except GaveUp as trouble:
                return [*runs, replace(run, seconds=limit, trouble=str(trouble))]
            runs.append(
                replace(
                    run,
                    deviation=deviation(outcome.tracks, peer.reference, self._view),
                    seconds=outcome.work.seconds,
                    evaluations=round(outcome.work.evaluations),
                    particle_steps=round(outcome.work.steps),
                    scaled=outcome.scaled,
                )
            )
        return runs


def _in_order(scene: Scene, schemes: Sequence[Scheme]) -> tuple[Scheme, ...]:
    """Schemes with those first that tell most: the scene's own, and the usual ones."""
    first = [scheme for scheme in dict.fromkeys((scene.integrator.scheme, *FIRST)) if scheme in schemes]
    return (*first, *(scheme for scheme in schemes if scheme not in first))

"""Is what `auto` chooses for the shipped scenes accurate and cheap enough? `python -m tests.auto.shipped [NAME …]`.

The choice is made for the scene as it is shipped. Its error is that of a run in the scene's own precision, measured
from a solution in double precision (dop853): of 95 in 100 particles that are seen in an eighth of the scene, in the
worst eighth. Particles are followed as long as that solution is known and can be had in the scene's precision: until it
parts from one of a larger tolerance, or a run of very many steps in single precision parts from it. From then on the
motion is chaotic, no integrator follows it, and nothing is said of it but how much that is.
Cost is counted, not timed: evaluations of the equations of motion, at the price that the kind of scheme has in the
engine. A choice is dear if a rival that costs at most two thirds of it is accurate enough.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from particlecli.accuracy.tracks import Ids, Track, Tracks
from particlecli.accuracy.trial import Outcome, Pace, Trial, suitable, trial_plan
from particlecli.auto.costs import cost, cost_together
from particlecli.auto.judge import metres
from particlecli.auto.resolve import resolved
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import ExplicitRungeKutta, ImplicitRungeKutta, Splitting
from particlecli.dynamics.plan import make_plan
from particlecli.dynamics.sampling import chosen
from particlecli.errors import SimulationError
from particlecli.render.camera import View, on_picture
from particlecli.runtime import Precision, start
from particlecli.scene.integrator import ADAPTIVE, Integrator, Scheme
from particlecli.scene.load import load_scene
from particlecli.scene.model import Scene

ROOT = Path(__file__).parents[2]
SHIPPED = sorted([*(ROOT / "scenes").glob("*.yaml"), *(ROOT / "scenes" / "reference").glob("*.yaml")])
RESULTS = ROOT / "outputs" / "auto_shipped.jsonl"

MOST = 1500
"""Particles of each group that are followed, at most; those that act on each other are all there."""

SPANS = {
    "scenes/dam_break": 0.04,
    "scenes/fish_school": 0.3,
    "scenes/flag": 0.5,
    "scenes/galaxies": 1.0,
    "scenes/gas": 0.6,
    "scenes/hair": 0.2,
    "scenes/jelly": 0.5,
    "scenes/sand": 0.1,
    "scenes/snake": 3.0,
    "reference/catenary": 0.3,
    "reference/dam_break": 0.02,
    "reference/elliptical_drop": 0.002,
    "reference/hydrostatic_tank": 0.1,
    "reference/taylor_green": 0.2,
}
"""How long scenes of many particles that act on each other are judged, s: a solution for all of them takes long."""

CHEAPER = 1 / 1.5
"""The part of its cost at which nothing else may be accurate enough."""

REFERENCES, SHARES = (1e-8, 1e-10), (1e-3, 1e-5)
"""Tolerances of the solution that tells how sure the other is, and of the one that errors are measured from, m; and
where particles act on each other, in parts of the error asked for, if that is more."""

UNSURE, KNOWN = 0.25, 0.5
"""In parts of the error asked for, how far apart the two are where particles are followed no longer; and the share of
a group that must be followed at a frame for it to count."""

FEW = 20
"""Of fewer particles than that the largest error counts."""

WINDOWS, ENOUGH = 8, 10
"""Parts of the scene, and particles seen in one that count."""

MANY, MANIER = 16, 2.0
"""Steps a frame of the run that tells what rounding does; of particles that act on each other, evaluations in parts of
those of the choice."""

LOOSE = [10.0 ** (-n / 2) for n in range(2, 17)]
"""Tolerances of adaptive rivals."""


@dataclass
class Verdict:
    """What was found of a scene.

    Attributes:
        scene: its name.
        choice: what `auto` says first.
        error, goal, unit: of the choice, and what was asked for; on the picture or in metres.
        followed: share of particles and frames at which the solution is known.
        span: how long the scene was looked at, s, and how long it lasts.
        cost: of a particle and frame, in evaluations at their price.
        evaluations: of a particle and frame, as counted.
        rivals: errors of others at two thirds of the cost or less.
    """

    scene: str
    choice: str
    error: float
    goal: float
    unit: str
    followed: float
    span: tuple[float, float]
    cost: float
    evaluations: float
    rivals: dict[str, float]

    @property
    def accurate(self) -> bool:
        """Whether the error is as small as asked for."""
        return self.error <= self.goal

    @property
    def cheaper(self) -> list[str]:
        """Rivals that are accurate enough."""
        return [name for name, error in self.rivals.items() if error <= self.goal]


def name_of(path: Path) -> str:
    """Folder and name of a scene."""
    return f"{path.parent.name}/{path.stem}"


def judged(path: Path, instead: Integrator | None = None) -> Verdict:
    """Let `auto` choose for a scene, and judge it, or what is to be judged instead."""
    described = load_scene(path, ["integrator={type: auto}"])
    changed, choice = resolved(described, 2)
    assert choice is not None
    own = instead or changed.integrator
    span = min(described.duration, SPANS.get(name_of(path), described.duration))
    pace = Pace(None if own.dt is None else round(1 / described.fps / own.dt), own.tolerance)
    scheme = own.scheme
    court = _Court(described.model_copy(update={"duration": span}))
    trial = court.trial(scheme, described.precision)
    run = trial.run(pace)
    court.heed_rounding(run)
    price = court.cost(scheme, run)
    found = Verdict(
        scene=name_of(path),
        choice=choice.lines()[0],
        error=court.error(run),
        goal=choice.goal.size,
        unit=choice.goal.unit,
        followed=court.followed,
        span=(span, described.duration),
        cost=price,
        evaluations=run.evaluations / court.particle_frames,
        rivals={},
    )
    for rival in court.rivals():
        made = trial if rival == scheme else None
        for each in court.paces(rival, CHEAPER * price):
            made = made or court.trial(rival, described.precision)
            with suppress(SimulationError):
                outcome = made.run(each)
                if court.cost(rival, outcome) > CHEAPER * price:
                    break
                found.rivals[f"{rival}, {each.steps or each.tolerance}"] = court.error(outcome)
    return found


class _Court:
    """A scene with the solution that errors are measured from."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._view = View.of(scene.camera, *scene.camera.resolution, scene.frames)
        plan = make_plan(scene)
        self._together = any(group.coupled for group in plan.groups)
        self._ids: dict[str, Ids] = {
            group.name: np.arange(group.births.total) if group.coupled else chosen(group.births, MOST)
            for group in plan.groups
        }
        trial = self.trial("dop853", "double")
        rough, fine = (trial.run(Pace(tolerance=tolerance)).tracks for tolerance in self._tolerances())
        self.particle_frames = max(1, sum(int(track.alive.sum()) for track in fine.values()))
        self._reference = self._known(rough, fine)

    def _tolerances(self) -> list[float]:
        if not self._together:
            return [*REFERENCES]
        allowed = metres(self._scene)
        return [max(least, share * allowed) for least, share in zip(REFERENCES, SHARES, strict=True)]

    @property
    def followed(self) -> float:
        """Share of particles and frames at which the solution is known."""
        return sum(int(track.alive.sum()) for track in self._reference.values()) / self.particle_frames

    def heed_rounding(self, run: Outcome) -> None:
        """Follow particles no longer than a run of very many steps does in the scene's precision."""
        if self._scene.precision == "double":
            return
        steps = MANY
        if self._together:
            steps = math.ceil(MANIER * run.evaluations / SCHEMES["rk4"].evaluations / self.particle_frames)
        rounded = self.trial("rk4", "single").run(Pace(steps)).tracks
        self._reference = self._known(rounded, self._reference)

    def trial(self, scheme: Scheme, precision: Precision) -> Trial:
        """A scheme on the scene."""
        start(precision, 2)
        return Trial(trial_plan(self._scene, scheme, precision, MOST), self._ids, measures_energy=False)

    def error(self, run: Outcome) -> float:
        """In the unit asked for; not a number where nothing is seen."""
        sizes = []
        for name, track in self._reference.items():
            errors = self._in_unit(track, run.tracks[name].positions - track.positions)
            parts = [part[~np.isnan(part)] for part in (*np.array_split(errors, WINDOWS), errors)]
            full = [part for part in parts if len(part) >= ENOUGH] or [part for part in parts[-1:] if len(part)]
            share = 1.0 if len(track.ids) < FEW else 0.95
            sizes += [float(np.quantile(part, share, method="inverted_cdf")) for part in full]
        return max(sizes, default=math.nan)

    def cost(self, scheme: Scheme, run: Outcome) -> float:
        """Of a particle and frame."""
        return self._price(scheme, run.evaluations / SCHEMES[scheme].evaluations / self.particle_frames)

    def rivals(self) -> list[Scheme]:
        """Explicit schemes, and the closed form."""
        return [name for name in suitable(self._scene) if not isinstance(SCHEMES[name], ImplicitRungeKutta)]

    def paces(self, scheme: Scheme, most: float) -> Iterator[Pace]:
        """The paces of a scheme that cost no more than allowed, or may."""
        if scheme in ADAPTIVE:
            if self._price(scheme, 1 / 8) <= most:
                yield from (Pace(tolerance=tolerance) for tolerance in LOOSE)
            return
        assert isinstance(SCHEMES[scheme], ExplicitRungeKutta | Splitting) or scheme == "exact"
        steps = 0
        while self._price(scheme, steps + 1) <= most:
            steps += 1
        yield from (Pace(each) for each in sorted({math.ceil(0.7 * steps), steps}) if each)

    def _price(self, scheme: Scheme, steps: float) -> float:
        return (cost_together if self._together else cost)(SCHEMES[scheme], steps)

    def _known(self, rough: Tracks, fine: Tracks) -> Tracks:
        """The fine solution as long as the rough one is near it."""
        allowed = UNSURE * self._scene.integrator.goal.size
        known = {}
        for name, track in fine.items():
            apart = self._in_unit(track, rough[name].positions - track.positions)
            lost = np.maximum.accumulate(apart > allowed, axis=0)
            few = (track.alive & ~lost).sum(axis=1) < KNOWN * track.alive.sum(axis=1)
            lost |= np.maximum.accumulate(few)[:, None]
            known[name] = Track(track.ids, np.where(lost[:, :, None], np.nan, track.positions), None)
        return known

    def _in_unit(self, track: Track, offset: np.ndarray) -> np.ndarray:
        """Of offsets the lengths in m, or on the picture, NaN where nothing is seen; all at one distance if none is."""
        if self._scene.integrator.goal.unit == "m":
            return np.linalg.norm(offset, axis=2)
        seen = on_picture(track.positions, offset, self._view)
        if not np.isnan(seen).all():
            return seen
        return np.linalg.norm(offset, axis=2) * self._view.focal / self._view.distance


def main() -> None:
    """Judges the scenes named on the command line, or all."""
    names = sys.argv[1:]
    RESULTS.parent.mkdir(exist_ok=True)
    for path in SHIPPED:
        if names and path.stem not in names and name_of(path) not in names:
            continue
        try:
            found = judged(path)
        except SimulationError as error:
            print(f"{name_of(path)}: {error}", flush=True)
            continue
        with RESULTS.open("a") as lines:
            lines.write(json.dumps(asdict(found)) + "\n")
        right = "ok  " if found.accurate and not found.cheaper else "FAIL"
        print(
            f"{right} {found.scene}: {found.choice}; true error {found.error:.2g} {found.unit}, followed "
            f"{found.followed:.0%} of {found.span[0]:g} of {found.span[1]:g} s; cost {found.cost:.3g}, "
            f"{found.evaluations:.3g} evaluations; enough at two thirds: {found.cheaper or 'none'} of {found.rivals}",
            flush=True,
        )


if __name__ == "__main__":
    main()

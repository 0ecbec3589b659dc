"""Is what `auto` chooses for the shipped scenes accurate and cheap enough? `python -m tests.auto.shipped [NAME …]`.

Scenes are judged as they are shipped, but for the span that `SPANS` tells where that is dear, and those of `STAGES`
where fewer of the same particles do the same within a shorter time. What is judged is the choice for just that; the one
for all of the scene, which may have to allow for more and cost more, has to be as accurate in the same span.
The error is that of a run in the scene's own precision, measured from a solution in double precision (dop853; where
grains remember contacts or bodies land, and of fluids, very many equal steps): of 95 in 100 particles that are seen in
an eighth of the scene, in the worst eighth; that of the particle furthest off is told beside it. Particles are followed
as long as that solution is known and can be had in the scene's precision: until it parts from one of a larger
tolerance, or of longer steps, or one of two runs of very many steps in single precision parts from it. From then on the
motion is chaotic, no integrator follows it, and nothing is said of it but how much that is.
Cost is counted, not timed: evaluations of the equations of motion, at the price that the kind of scheme has in the
engine. A choice is dear if a rival that costs at most two thirds of it is accurate enough.
"""

from __future__ import annotations

import json
import sys
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path

from particlecli.accuracy.trial import Pace
from particlecli.auto.resolve import resolved
from particlecli.errors import SimulationError
from particlecli.scene.integrator import Integrator
from particlecli.scene.load import load_scene
from particlecli.scene.model import Scene
from tests.auto.court import THREADS, Court

ROOT = Path(__file__).parents[2]
SHIPPED = sorted([*(ROOT / "scenes").glob("*.yaml"), *(ROOT / "scenes" / "reference").glob("*.yaml")])
RESULTS = ROOT / "outputs" / "auto_shipped.jsonl"

SPANS = {
    "scenes/dam_break": 0.2,
    "scenes/fish_school": 3.0,
    "scenes/flag": 0.8,
    "scenes/galaxies": 2.0,
    "scenes/gas": 0.6,
    "scenes/hair": 0.6,
    "scenes/jelly": 0.8,
    "reference/catenary": 2.0,
}
"""How long scenes of many particles that act on each other are judged, s: a solution for all of them takes long."""

STAGES = {
    "scenes/sand": [
        "duration=0.35",
        "particles.grains.layout.center=[0, 1.3, 0]",
        "particles.grains.layout.size=[0.65, 2.1, 0.65]",
    ],
}
"""What is changed in scenes whose physics begins too late for a solution of all their particles."""

CHEAPER = 1 / 1.5
"""The part of its cost at which nothing else may be accurate enough."""


@dataclass
class Verdict:
    """What was found of a scene.

    Attributes:
        scene: its name.
        choice: what `auto` says first.
        error, goal, unit: of the choice, and what was asked for; on the picture or in metres.
        shipped, shipped_error: the same for the scene as it is shipped, where it is judged in part.
        largest: error of the particle furthest off: how far the choice is from the strictest reading of what was asked.
        all_within: whether it too is as small as was asked for, which is not required.
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
    shipped: str
    shipped_error: float
    largest: float
    all_within: bool
    followed: float
    span: tuple[float, float]
    cost: float
    evaluations: float
    rivals: dict[str, float]

    @property
    def accurate(self) -> bool:
        """Whether the errors are as small as asked for."""
        return max(self.error, self.shipped_error) <= self.goal

    @property
    def cheaper(self) -> list[str]:
        """Rivals that are accurate enough."""
        return [name for name, error in self.rivals.items() if error <= self.goal]


def name_of(path: Path) -> str:
    """Folder and name of a scene."""
    return f"{path.parent.name}/{path.stem}"


def judged(path: Path, instead: Integrator | None = None) -> Verdict:
    """Let `auto` choose for a scene, and judge it, or what is to be judged instead."""
    shipped = load_scene(path, ["integrator={type: auto}"])
    stage = load_scene(path, ["integrator={type: auto}", *STAGES.get(name_of(path), [])])
    span = min(stage.duration, SPANS.get(name_of(path), stage.duration))
    stage = stage.model_copy(update={"duration": span, "reference": ()})
    changed, choice = resolved(stage, THREADS)
    assert choice is not None
    own = instead or changed.integrator
    scheme = own.scheme
    court = Court(stage)
    trial = court.trial(scheme, stage.precision)
    run = trial.run(_pace(own, stage))
    court.heed_rounding(run)
    price, whole, whole_error = court.cost(scheme, run), "", 0.0
    if span < shipped.duration and instead is None:
        changed, for_all = resolved(shipped, THREADS)
        assert for_all is not None
        whole = for_all.lines()[0]
        outcome = court.trial(changed.integrator.scheme, stage.precision).run(_pace(changed.integrator, stage))
        whole_error = court.error(outcome)
        trial = court.trial(scheme, stage.precision)  # anew: the other choice may have restarted the runtime
    found = Verdict(
        scene=name_of(path),
        choice=choice.lines()[0],
        error=court.error(run),
        goal=choice.goal.size,
        unit=choice.goal.unit,
        shipped=whole,
        shipped_error=whole_error,
        largest=(largest := court.error(run, 1.0)),
        all_within=largest <= choice.goal.size,
        followed=court.followed,
        span=(span, shipped.duration),
        cost=price,
        evaluations=run.evaluations / court.particle_frames,
        rivals={},
    )
    for rival in court.rivals():
        made = trial if rival == scheme else None
        for each in court.paces(rival, CHEAPER * price):
            made = made or court.trial(rival, stage.precision)
            with suppress(SimulationError):
                outcome = made.run(each)
                if court.cost(rival, outcome) > CHEAPER * price:
                    break
                found.rivals[f"{rival}, {each.steps or each.tolerance}"] = court.error(outcome)
    return found


def _pace(integrator: Integrator, scene: Scene) -> Pace:
    """An integrator's steps or tolerance."""
    steps = None if integrator.dt is None else round(1 / scene.fps / integrator.dt)
    return Pace(steps, integrator.tolerance)


def _whole(found: Verdict) -> str:
    return f"as shipped ({found.shipped}) {found.shipped_error:.2g}, " if found.shipped else ""


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
            f"{right} {found.scene}: {found.choice}; true error {found.error:.2g} {found.unit}, "
            f"at most {found.largest:.2g}, {_whole(found)}"
            f"followed {found.followed:.0%} of {found.span[0]:g} of {found.span[1]:g} s; "
            f"cost {found.cost:.3g}, {found.evaluations:.3g} evaluations; "
            f"enough at two thirds: {found.cheaper or 'none'} of {found.rivals}",
            flush=True,
        )


if __name__ == "__main__":
    main()

"""The court that judges what `auto` chooses: a converged solution, errors from it, and what rivals cost."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from particlecli.accuracy.tracks import Ids, Track, Tracks
from particlecli.accuracy.trial import Outcome, Pace, Trial, suitable, trial_plan
from particlecli.auto.costs import cost, cost_together
from particlecli.auto.judge import metres
from particlecli.auto.terms import lands, remembers
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import ExplicitRungeKutta, ImplicitRungeKutta, Splitting
from particlecli.dynamics.plan import Plan, make_plan
from particlecli.dynamics.sampling import chosen
from particlecli.render.camera import View, on_picture
from particlecli.runtime import Precision, start
from particlecli.scene.forces import Sph
from particlecli.scene.integrator import ADAPTIVE, Scheme
from particlecli.scene.model import Scene

MOST = 1500
"""Particles of each group that are followed, at most; those that act on each other are all there."""

REFERENCES, SHARES = (1e-8, 1e-10), (1e-3, 1e-5)
"""Tolerances of the solution that tells how sure the other is, and of the one that errors are measured from, m; and
where particles act on each other, in parts of the error asked for, if that is more."""

TOUCHING, FLUID = ("symplectic_euler", 1000, 4000), ("rk4", 50, 150)
"""Scheme and steps a frame of the two solutions where grains remember contacts or bodies land, and of fluids: contacts
change, and planes are met, at the ends of steps. Steps that are chosen by their error become ever shorter there, or see
nothing of it, and the solution is the limit of equal ones."""

UNSURE, KNOWN = 0.25, 0.5
"""In parts of the error asked for, how far apart the two are where particles are followed no longer; and the share of
a group that must be followed at a frame for it to count."""

THREADS = 1
"""Of each run: scenes can be judged side by side."""

FEW = 20
"""Of fewer particles than that the largest error counts."""

WINDOWS, ENOUGH = 8, 10
"""Parts of the scene, and particles seen in one that count."""

MANY, MANIER = 16, 4.0
"""Steps a frame of the first run that tells what rounding does; of particles that act on each other, evaluations in
parts of those of the choice."""

LOOSE = [10.0 ** (-n / 2) for n in range(2, 17)]
"""Tolerances of adaptive rivals."""


class Court:
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
        self._even = _even(plan)
        scheme, *steps = self._even or ("dop853",)
        trial = self.trial(scheme, "double")
        paces = [Pace(each) for each in steps] or [Pace(tolerance=each) for each in self._tolerances()]
        rough, fine = (trial.run(pace).tracks for pace in paces)
        self.particle_frames = max(1, sum(int(track.alive.sum()) for track in fine.values()))
        self._fine = fine
        self._reference = self._known(rough, fine)

    def _tolerances(self) -> list[float]:
        if not self._together:
            return [*REFERENCES]
        allowed = metres(self._scene)
        return [max(least, share * allowed) for least, share in zip(REFERENCES, SHARES, strict=True)]

    @property
    def followed(self) -> float:
        """Share of particles and frames, after the first, at which the solution is known."""
        known = sum(int(track.alive[1:].sum()) for track in self._reference.values())
        return known / max(1, sum(int(track.alive[1:].sum()) for track in self._fine.values()))

    def heed_rounding(self, run: Outcome) -> None:
        """Follow particles no longer than runs of very many steps do in the scene's precision.

        Rounding is as good as random, so that one run may follow them by luck.
        """
        if self._scene.precision == "double":
            return
        scheme, steps = "rk4", MANY
        if self._even:
            scheme, steps, _ = self._even
        elif self._together:
            steps = math.ceil(MANIER * run.evaluations / SCHEMES["rk4"].evaluations / self.particle_frames)
        trial = self.trial(scheme, "single")
        for times in (1, 2):
            self._reference = self._known(trial.run(Pace(times * steps)).tracks, self._reference)

    def trial(self, scheme: Scheme, precision: Precision) -> Trial:
        """A scheme on the scene."""
        start(precision, THREADS)
        return Trial(trial_plan(self._scene, scheme, precision, MOST), self._ids, measures_energy=False)

    def error(self, run: Outcome, share: float = 0.95) -> float:
        """What so many of the particles do not exceed, in the unit asked for; not a number where nothing is seen."""
        sizes = []
        for name, track in self._reference.items():
            errors = self._in_unit(track, run.tracks[name].positions - track.positions)
            parts = [part[~np.isnan(part)] for part in (*np.array_split(errors, WINDOWS), errors)]
            full = [part for part in parts if len(part) >= ENOUGH] or [part for part in parts[-1:] if len(part)]
            within = 1.0 if len(track.ids) < FEW else share
            sizes += [float(np.quantile(part, within, method="inverted_cdf")) for part in full]
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


def _even(plan: Plan) -> tuple[Scheme, int, int] | None:
    """Scheme and steps of both solutions, where they are of equal steps."""
    if remembers(plan.scene) or lands(plan):
        return TOUCHING
    return FLUID if any(isinstance(force, Sph) for force in plan.scene.forces) else None

"""How far pilots are off: from flights that are accurate enough to tell, as long as these themselves agree."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from particlecli.auto.growth import growth, growth_rate
from particlecli.auto.pilot import Flight, Pilot
from particlecli.auto.steps import Doubles
from particlecli.auto.terms import STEADY, Terms, remembers
from particlecli.auto.whole import WholePilot
from particlecli.dynamics.integrators import SCHEMES
from particlecli.render.camera import View, on_picture
from particlecli.scene.integrator import UNCHOSEN
from particlecli.scene.model import Scene

Mask = NDArray[np.bool_]

FIRST, COARSEST = 1e-3, 1e-4
"""The tolerance of the first reference, in parts of the error asked for, m, and the largest."""

LOOSEST = 1e-2
"""The largest tolerance of adaptive schemes that is tried; the smallest is that of the judge."""

FINER = 1e-2
"""Of a tolerance: the next one."""

AGREED, KNOWN = 0.1, 0.25
"""Parts of the error asked for: references so near each other need not be refined, and where the best two are further
apart than so much nothing can be told of a particle from then on."""

LEAST, MOST = 0.02, 0.5
"""Share of a pilot's flight that must be known if anything is to be told, and of its particles at a frame: of fewer the
references agree by chance."""

SECOND, CHAOTIC, MAGNIFIED = 2.0, 1.5, 0.05
"""Evaluations of the second reference where no smaller tolerance makes one, in parts of the first. Where the motion is
chaotic, or such a share of the flights is lost, two with equal steps are the references: with as many evaluations as
the first, and so many times more."""

FINE, HALVINGS = 10, 2
"""Steps of the first reference where they are equal, in parts of the fewest safe ones; and how often they are halved at
most, until no more of the flights is lost than `MAGNIFIED`: what is lost would be what errors are largest of."""

FEW = 20
"""Of fewer particles than that the largest error counts, of more that which 95 in 100 do not exceed."""

WINDOWS, ENOUGH = 8, 10
"""Spans that what is known is cut into, of which the worst counts, and errors in one that tell something."""


@dataclass(frozen=True)
class _Reference:
    """What the flights of a pilot are compared with.

    Attributes:
        positions: at each frame, shape (frames, n, 3), m; not a number where nothing is known.
        growth: by how much errors grow after the flight.
        chaotic: whether exponentially, so that the last of them counts.
    """

    positions: Doubles
    growth: float
    chaotic: bool


class Judge:
    """Measures the flights of the pilots of a scene.

    Args:
        scene: with `integrator.type: auto`.
        pilots: of its groups, all of which have something to fly for.
        terms: on which schemes are compared.
        safe: the fewest safe steps in a frame of `STEADY`, where contacts ask for equal steps.

    Attributes:
        unknown: share of all that was flown of which nothing can be told: there the motion magnifies rounding.
        evaluations: of the first reference, for each particle and frame.
        most_evaluations: of equal steps that can be judged.
        spoilt: error of the first reference, at the smallest tolerance, where chaos magnifies its rounding; else 0.
    """

    def __init__(
        self, scene: Scene, pilots: Sequence[Pilot | WholePilot], terms: Terms, safe: int | None = None
    ) -> None:
        self._scene, self._pilots, self._terms, self._safe = scene, pilots, terms, safe
        self._goal = scene.integrator.goal
        self._view = View.of(scene.camera, *scene.camera.resolution, scene.frames)
        alive = known = 0
        self.evaluations = 0.0
        self._blind, self._magnified = False, False
        self._firsts: list[Flight] = []
        self._references: list[_Reference] = []
        for pilot in pilots:
            positions, apart, rate = self._best(pilot)
            flown = int((~np.isnan(positions[:, :, 0])).sum())
            unsure = self._unsure(positions, apart)
            positions[unsure], apart[unsure] = np.nan, np.nan
            sure = int((~np.isnan(positions[:, :, 0])).sum())
            self._blind |= sure < LEAST * flown
            alive, known = alive + flown, known + sure
            self._references.append(_Reference(positions, self._growth(pilot, positions, apart, rate), rate > 0.0))
        self.most_evaluations = self.evaluations * self._most()
        self.unknown = 1.0 - known / alive if alive else 0.0
        self.spoilt = self.error(self._firsts) if self._magnified else 0.0

    def error(self, flights: Sequence[Flight]) -> float:
        """Of 95 in 100 particles of the group that is furthest off, at the worst time, in the unit asked for."""
        errors = [np.inf] if self._blind else []
        for pilot, reference, flight in zip(self._pilots, self._references, flights, strict=True):
            known = reference.positions
            lengths = _apart(flight.positions, known)
            lengths = np.where(np.isnan(lengths) & ~np.isnan(known[:, :, 0]), np.inf, lengths)
            sizes = self._in_unit(known, lengths)
            worst = _worst(pilot, sizes)
            errors.append((max(worst, _sizes(sizes)[-1]) if reference.chaotic else worst) * reference.growth)
        return max(errors)

    def _most(self) -> float:
        """Evaluations that equal steps may take, in parts of those of the first reference."""
        if self._safe is None:
            return self._terms.most_of_judge
        return 1.0 if remembers(self._scene) else 2.0

    def _best(self, pilot: Pilot | WholePilot) -> tuple[Doubles, Doubles, float]:
        """Positions, how far another flight is from them, and the rate of exponential growth of errors, per frame.

        The other flight has a larger tolerance, or equal steps. In single precision chaos magnifies the rounding of
        adaptive steps too much, and both have equal steps.
        """
        if self._safe is not None:
            return self._steady(pilot, self._safe)
        judge, precision = SCHEMES[self._terms.judge], self._scene.precision
        tolerance = max(min(FIRST * metres(self._scene), COARSEST), self._terms.finest[precision])
        first = pilot.fly(judge, tolerance=tolerance)
        self.evaluations = max(self.evaluations, first.evaluations)
        self._firsts.append(first)
        rate = self._rate(pilot, first.positions)
        if self._terms.deepest[precision] >= tolerance:
            return *self._rounded(pilot, first, chaotic=rate > 0.0), rate
        before = first.positions
        for _ in range(self._terms.refinements):
            tolerance = max(FINER * tolerance, self._terms.deepest[precision])
            best = pilot.fly(judge, tolerance=tolerance).positions
            apart = self._in_unit(best, _apart(before, best))
            if _worst(pilot, apart) <= AGREED * self._goal.size or tolerance == self._terms.deepest[precision]:
                break
            before = best
        return best.copy(), apart, rate

    def _rounded(self, pilot: Pilot | WholePilot, first: Flight, *, chaotic: bool) -> tuple[Doubles, Doubles]:
        """Positions, and how far another flight is from them, where no smaller tolerance makes a better one."""
        even, steps = SCHEMES[UNCHOSEN], first.evaluations / SCHEMES[UNCHOSEN].evaluations
        finer = pilot.fly(even, steps=math.ceil((CHAOTIC if chaotic else SECOND) * steps)).positions
        apart = self._in_unit(first.positions, _apart(finer, first.positions))
        if not chaotic and self._unsure(first.positions, apart).mean() <= MAGNIFIED:
            return first.positions.copy(), apart
        self._magnified = True
        coarser = pilot.fly(even, steps=math.ceil(steps)).positions
        return finer.copy(), self._in_unit(finer, _apart(coarser, finer))

    def _steady(self, pilot: Pilot | WholePilot, safe: int) -> tuple[Doubles, Doubles, float]:
        """The same of the last two of some flights with equal steps, of first order.

        But for grains that remember contacts, which do not come together so evenly, the positions are Richardson's
        extrapolation to steps of no length (Phil. Trans. R. Soc. A 210 (1911) 307).
        """
        flights = [pilot.fly(SCHEMES[STEADY], steps=FINE * safe)]
        for halvings in range(1, HALVINGS + 1):
            flights.append(pilot.fly(SCHEMES[STEADY], steps=FINE * safe * 2**halvings))
            first, best = flights[-2:]
            apart = self._in_unit(best.positions, _apart(first.positions, best.positions))
            if remembers(self._scene) or self._unsure(best.positions, apart).mean() <= MAGNIFIED:
                break
        self.evaluations = max(self.evaluations, first.evaluations)
        self._firsts.append(first)
        if remembers(self._scene):
            return best.positions.copy(), apart, 0.0
        return 2.0 * best.positions - first.positions, apart, 0.0

    def _rate(self, pilot: Pilot | WholePilot, reference: Doubles) -> float:
        """Of the exponential growth of errors, per frame, where a pilot flies for a few frames only; else 0."""
        if isinstance(pilot, Pilot) or pilot.sees_all:
            return 0.0
        rough = pilot.fly(SCHEMES[self._terms.judge], tolerance=LOOSEST).positions
        return growth_rate(_sizes(self._in_unit(reference, _apart(rough, reference))))

    def _growth(self, pilot: Pilot | WholePilot, reference: Doubles, apart: Doubles, rate: float) -> float:
        """By how much errors grow after what was flown; collisions of grains leave nothing that could be told."""
        if remembers(self._scene):
            return 1.0
        last = pilot.frames >= pilot.flown
        return growth(
            pilot.flown,
            int(pilot.frames.max()),
            lost=float(np.isnan(reference[-1, last, 0]).mean()),
            rate=rate,
            bound=KNOWN * self._goal.size / max(_sizes(apart)[-1], 1e-300),
        )

    def _unsure(self, positions: Doubles, apart: Doubles) -> Mask:
        """Where nothing can be told of a particle any longer, shape (frames, n)."""
        far = ~(apart <= KNOWN * self._goal.size) & ~np.isnan(apart)
        lost = np.maximum.accumulate(far, axis=0)
        alive = ~np.isnan(positions[:, :, 0])
        few = (alive & ~lost).sum(axis=1) < MOST * alive.sum(axis=1)
        return np.asarray(lost | np.maximum.accumulate(few)[:, None])

    def _in_unit(self, positions: Doubles, lengths: Doubles) -> Doubles:
        """Lengths in m, or in pixels; where no particle of a group is seen, as seen from the point looked at."""
        if self._goal.unit == "m":
            return lengths
        finite = np.where(np.isfinite(lengths), lengths, np.where(np.isnan(lengths), np.nan, 1e9))
        with np.errstate(over="ignore"):
            seen = on_picture(positions, finite[:, :, None] * self._view.right, self._view)
        return finite * self._view.focal / self._view.distance if np.isnan(seen).all() else seen


def _apart(one: Doubles, other: Doubles) -> Doubles:
    with np.errstate(over="ignore"):
        return np.asarray(np.linalg.norm(one - other, axis=2))


def _worst(pilot: Pilot | WholePilot, errors: Doubles) -> float:
    """The largest size over spans of what is known of errors at each frame after birth, shape (frames, n)."""
    ages = np.arange(1, len(errors) + 1)[:, None]
    lives = (ages <= pilot.frames) & ~np.isnan(errors)
    frames = pilot.first_frames + ages
    last = float(frames.max(initial=1.0, where=lives))
    windows = np.minimum((frames / last * WINDOWS).astype(int), WINDOWS - 1)
    few = errors.shape[1] < FEW
    sizes = [_size(errors[lives & (windows == window)], few=few) for window in range(WINDOWS)]
    known = [size for size in sizes if size is not None]
    return max(known) if known else _size(errors[lives], 1, few=few) or 0.0


def _sizes(errors: Doubles) -> Doubles:
    """What 95 in 100 do not exceed at each frame, of errors of shape (frames, n); 0 where there are none."""
    few = errors.shape[1] < FEW
    return np.array([_size(each[~np.isnan(each)], 1, few=few) or 0.0 for each in errors])


def _size(values: Doubles, enough: int = ENOUGH, *, few: bool) -> float | None:
    share = 1.0 if few else 0.95
    return float(np.quantile(values, share, method="inverted_cdf")) if len(values) >= enough else None


def metres(scene: Scene) -> float:
    """The error asked of `auto`, m; that of pixels as long as it is at the point looked at."""
    goal = scene.integrator.goal
    if goal.unit == "m":
        return goal.size
    view = View.of(scene.camera, *scene.camera.resolution, scene.frames)
    return goal.size * view.distance / view.focal

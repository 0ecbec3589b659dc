"""The choice of scheme and step for a scene: the cheapest that pilots find to be within the error asked for."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from particlecli.auto.pilot import Flight, Pilot
from particlecli.auto.steps import Doubles
from particlecli.auto.terms import ALONE, Terms
from particlecli.auto.whole import WholePilot
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import ClosedForm, ImplicitRungeKutta
from particlecli.render.camera import View, on_picture
from particlecli.scene.checks import problems
from particlecli.scene.integrator import ADAPTIVE, Goal, Integrator, Scheme
from particlecli.scene.model import Scene

REFERENCE, COARSEST = 1e-3, 1e-4
"""The tolerance of the flight that others are compared with, in parts of the error asked for, m, and the largest."""

MARGIN = 2.0
"""The error of a pilot is to be so many times smaller than what is asked for: it stands for more than it has seen."""

WINDOWS, ENOUGH = 8, 10
"""Spans that the scene is cut into, of which the worst counts, and errors in one that tell something."""

LOOSEST, TIGHTEST = 1e-2, 1e-12
"""Tolerances of adaptive schemes that are tried."""

MOST_SOLVED = 3_000
"""Evaluations in a row that a pilot may take where they belong to equations that are solved, launch by launch."""

EXPLODED = 1e6
"""An error that is so many times what is asked for means that an explicit scheme has blown up: the motion is stiff."""

MOST_TRIES = 8


@dataclass(frozen=True)
class Tried:
    """A scheme that was considered.

    Attributes:
        scheme: its name.
        steps: equal steps in a frame; none for an adaptive scheme.
        tolerance: of an adaptive scheme.
        error: found by the pilots, in the unit asked for; none where none flew.
        cost: of a particle and frame, in evaluations of a scheme that works on packs.
        why: what spoke against it; empty for the one chosen.
    """

    scheme: Scheme
    steps: int | None
    tolerance: float | None
    error: float | None
    cost: float
    why: str

    @property
    def pace(self) -> str:
        """Its steps or its tolerance, in words."""
        if self.steps is None:
            return f"tolerance {self.tolerance:g}"
        return f"{self.steps} step{'s' if self.steps > 1 else ''} a frame"


@dataclass(frozen=True)
class Choice:
    """What was chosen for a scene, and what was not.

    Attributes:
        goal: the error asked for.
        chosen: what is known of the choice.
        rejected: the others, in the order in which they were considered.
        unseen: why pilots do not tell, if they do not.
    """

    goal: Goal
    chosen: Tried
    rejected: tuple[Tried, ...] = ()
    unseen: str = ""

    @property
    def holds(self) -> bool:
        """Whether pilots found it to be as accurate as asked for."""
        return self.chosen.error is not None and self.chosen.error <= self.goal.size

    def lines(self) -> list[str]:
        """In words, what was chosen and what was not, and why."""
        goal, chosen = self.goal, self.chosen
        found = "" if chosen.error is None else f": pilots err by {chosen.error:.2g} {goal.unit}"
        return [
            f"auto chose {chosen.scheme}, {chosen.pace}{found}, {goal.size:g} {goal.unit} are allowed",
            *(f"  not {each.scheme}, {each.pace}: {each.why}" for each in self.rejected),
            *([f"  pilots do not tell: {self.unseen}; the run reports its error"] if self.unseen else []),
        ]


def choose(scene: Scene, pilots: Sequence[Pilot | WholePilot], terms: Terms = ALONE) -> Choice:
    """Find the cheapest scheme and step that keep the error asked for.

    The same scene gets the same choice on every machine: evaluations are counted, not timed.

    Args:
        scene: with `integrator.type: auto`.
        pilots: of its groups.
        terms: on which schemes are compared.
    """
    search = _Search(scene, pilots, terms)
    tried = [search.of(scheme) for scheme in terms.candidates if not problems(_with(scene, scheme))]
    best = search.best or min(tried, key=lambda each: math.inf if each.error is None else each.error)
    rejected = [_outdone(each, best) for each in tried if each is not best]
    return Choice(search.goal, best, tuple(rejected))


def _outdone(tried: Tried, best: Tried) -> Tried:
    """A scheme that would have done, had there not been a cheaper one."""
    if tried.why:
        return tried
    return Tried(**{**vars(tried), "why": f"costs {tried.cost / best.cost:.2g} times as much"})


class _Search:
    """Looks for the pace of each scheme, and remembers the cheapest."""

    def __init__(self, scene: Scene, pilots: Sequence[Pilot | WholePilot], terms: Terms) -> None:
        self._terms = terms
        self.goal = scene.integrator.goal
        self.best: Tried | None = None
        self._scene = scene
        self._view = View.of(scene.camera, *scene.camera.resolution, scene.frames)
        self._fewest = max(1, math.ceil(1.0 / scene.fps / (scene.integrator.dt or math.inf) * (1.0 - 1e-9)))
        self._pilots = [pilot for pilot in pilots if pilot.moves]
        tolerance = min(max(REFERENCE * metres(scene), terms.finest[scene.precision]), COARSEST)
        self._references = [pilot.fly(SCHEMES[terms.judge], tolerance=tolerance).positions for pilot in self._pilots]
        self._frames = max((pilot.flown for pilot in self._pilots), default=1)
        self._stiff = False

    def of(self, scheme: Scheme) -> Tried:
        """The longest step, or largest tolerance, with which a scheme is accurate enough, if it can be cheapest."""
        if isinstance(SCHEMES[scheme], ClosedForm) or not self._pilots:
            return self._judged(Tried(scheme, self._fewest, None, 0.0, self._cost(scheme, self._fewest), ""))
        last: Tried | None = None
        for each in self._adaptive(scheme) if scheme in ADAPTIVE else self._even(scheme):
            last = each
            if not each.why and each.error is not None and each.error <= self.goal.size / MARGIN:
                return self._judged(each)
        assert last is not None
        return last if last.why else Tried(**{**vars(last), "why": "not accurate enough at any pace that was tried"})

    def _judged(self, tried: Tried) -> Tried:
        if self.best is None or tried.cost < self.best.cost:
            self.best = tried
        return tried

    def _even(self, scheme: Scheme) -> Iterator[Tried]:
        """Ever more steps, by what the order of the scheme foretells."""
        steps, error, order = self._fewest, None, SCHEMES[scheme].order
        solves = isinstance(SCHEMES[scheme], ImplicitRungeKutta)
        for _ in range(MOST_TRIES):
            price = self._cost(scheme, steps)
            if self.best is not None and price >= self.best.cost:
                yield Tried(scheme, steps, None, error, price, self._dearer(price))
                return
            if steps * SCHEMES[scheme].evaluations * self._frames > (MOST_SOLVED if solves else self._terms.most_calls):
                yield Tried(scheme, steps, None, error, price, f"would need {steps} steps a frame or more")
                return
            if solves and self.best is not None and not self._stiff:
                yield Tried(scheme, steps, None, error, price, "nothing here is stiff")
                return
            error = self._error(lambda pilot, n=steps: pilot.fly(SCHEMES[scheme], steps=n))  # type: ignore[misc]
            self._stiff |= not error < EXPLODED * self.goal.size
            yield Tried(scheme, steps, None, error, price, "")
            excess = error * MARGIN / self.goal.size
            steps = math.ceil(steps * min(max(1.05 * excess ** (1.0 / order), 1.2), 8.0)) if excess < 1e6 else 2 * steps

    def _adaptive(self, scheme: Scheme) -> Iterator[Tried]:
        """Ever smaller tolerances, by powers of ten."""
        tolerance, error = LOOSEST, None
        price = self._cost(scheme, 1)
        for _ in range(MOST_TRIES):
            if self.best is not None and price >= self.best.cost:
                yield Tried(scheme, None, tolerance, error, price, self._dearer(price))
                return
            flights = [pilot.fly(SCHEMES[scheme], tolerance=tolerance) for pilot in self._pilots]
            error = self._error_of(flights)
            evaluations = max(flight.evaluations for flight in flights)
            price = self._cost(scheme, evaluations / SCHEMES[scheme].evaluations)
            dearer = self.best is not None and price >= self.best.cost
            yield Tried(scheme, None, tolerance, error, price, self._dearer(price) if dearer else "")
            excess = error * MARGIN / self.goal.size
            tolerance /= 10.0 ** max(1, math.floor(math.log10(max(excess, 1.0)))) if math.isfinite(excess) else 10.0
            if tolerance < TIGHTEST:
                return

    def _dearer(self, price: float) -> str:
        assert self.best is not None
        return f"would cost {price / self.best.cost:.2g} times as much as {self.best.scheme} or more"

    def _cost(self, scheme: Scheme, steps: float) -> float:
        return self._terms.cost(SCHEMES[scheme], steps)

    def _error(self, fly: Callable[[Pilot | WholePilot], Flight]) -> float:
        return self._error_of([fly(pilot) for pilot in self._pilots])

    def _error_of(self, flights: list[Flight]) -> float:
        """Of 95 in 100 particles of the group that is furthest off, at the worst time, in the unit asked for."""
        errors = []
        for pilot, reference, flight in zip(self._pilots, self._references, flights, strict=True):
            with np.errstate(over="ignore"):
                lengths = np.linalg.norm(flight.positions - reference, axis=2)
            lengths = np.where(np.isnan(lengths) & ~np.isnan(reference[:, :, 0]), np.inf, lengths)
            errors.append(_worst(pilot, self._in_unit(reference, lengths)))
        return max(errors)

    def _in_unit(self, positions: Doubles, lengths: Doubles) -> Doubles:
        """Lengths in m, or in pixels; where no particle of a group is seen, as seen from the point looked at."""
        if self.goal.unit == "m":
            return lengths
        finite = np.where(np.isfinite(lengths), lengths, 1e9)
        seen = on_picture(positions, finite[:, :, None] * self._view.right, self._view)
        return finite * self._view.focal / self._view.distance if np.isnan(seen).all() else seen


def _worst(pilot: Pilot | WholePilot, errors: Doubles) -> float:
    """The largest 95th percentile over spans of the scene; errors at each frame after birth, shape (frames, n)."""
    ages = np.arange(1, len(errors) + 1)[:, None]
    lives = (ages <= pilot.frames) & ~np.isnan(errors)
    last = max(1.0, float(pilot.frames.max()) + pilot.first_frames.max())
    windows = np.minimum(((pilot.first_frames + ages) / last * WINDOWS).astype(int), WINDOWS - 1)
    sizes = [_p95(errors[lives & (windows == window)]) for window in range(WINDOWS)]
    known = [size for size in sizes if size is not None]
    worst = max(known) if known else _p95(errors[lives], 1) or 0.0
    return worst * max(1.0, float(pilot.frames.max()) / pilot.flown)


def _p95(values: Doubles, enough: int = ENOUGH) -> float | None:
    return float(np.quantile(values, 0.95, method="inverted_cdf")) if len(values) >= enough else None


def integrator_of(scene: Scene, chosen: Tried) -> Integrator:
    """What to put in the place of a scene's `auto`."""
    own = scene.integrator
    step = None if chosen.steps is None else 1.0 / scene.fps / chosen.steps
    return Integrator(
        type=chosen.scheme,
        dt=own.dt if step is None else step,
        tolerance=chosen.tolerance,
        contact=own.contact,
        allow_unstable=own.allow_unstable,
    )


def _with(scene: Scene, scheme: Scheme) -> Scene:
    return scene.model_copy(update={"integrator": Integrator(type=scheme, contact=scene.integrator.contact)})


def metres(scene: Scene) -> float:
    """The error asked of `auto`, m; that of pixels as long as it is at the point looked at."""
    goal = scene.integrator.goal
    if goal.unit == "m":
        return goal.size
    view = View.of(scene.camera, *scene.camera.resolution, scene.frames)
    return goal.size * view.distance / view.focal

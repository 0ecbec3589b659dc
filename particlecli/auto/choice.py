"""The choice of scheme and step for a scene: the cheapest that pilots find to be within the error asked for."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from particlecli.auto.judge import LOOSEST, Judge
from particlecli.auto.outcome import Choice, Tried
from particlecli.auto.pilot import Flight, Pilot
from particlecli.auto.safe import SafeSteps
from particlecli.auto.terms import ALONE, STEADY, UNSEEN, Terms, remembers
from particlecli.auto.whole import WholePilot
from particlecli.dynamics.integrators import SCHEMES
from particlecli.dynamics.integrators.base import ClosedForm, ImplicitRungeKutta
from particlecli.scene.checks import problems
from particlecli.scene.integrator import ADAPTIVE, Integrator, Scheme
from particlecli.scene.model import Scene

MARGIN, SEEN = 1.5, 1.2
"""The error of a pilot is to be so many times smaller than what is asked for: it stands for more than it has seen; and
where it has seen all particles until the end of the scene, as what it is measured from is not exact either."""

MOST_SOLVED = 3_000
"""Evaluations in a row that a pilot may take where they belong to equations that are solved, launch by launch."""

BEGUN = 0.4
"""Of the cost of an adaptive scheme that is accurate enough: that of the steps of others that are tried first."""

CLOSE = 1.15
"""Steps that are enough are few enough where so many times fewer are not."""

EXPLODED = 1e6
"""An error that is so many times what is asked for means that an explicit scheme has blown up: the motion is stiff."""

MOST_TRIES = 12


def choose(scene: Scene, pilots: Sequence[Pilot | WholePilot], terms: Terms, safe: SafeSteps) -> Choice:
    """Find the cheapest scheme and step that keep the error asked for.

    The same scene gets the same choice on every machine: evaluations are counted, not timed.

    Args:
        scene: with `integrator.type: auto`.
        pilots: of its groups.
        terms: on which schemes are compared.
        safe: how long their steps may be.
    """
    search = _Search(scene, pilots, terms, safe)
    tried = [search.of(scheme) for scheme in terms.candidates if _fits(scene, scheme, terms, pilots)]
    best = search.best or min(tried, key=lambda each: math.inf if each.error is None else each.error)
    rejected = [_outdone(each, best) for each in tried if each is not best]
    return Choice(search.goal, best, tuple(rejected), unknown=search.unknown)


def _contacts_tell(scene: Scene, pilots: Sequence[Pilot | WholePilot]) -> bool:
    """Whether contacts ask for equal steps, and errors are told by such."""
    return remembers(scene) or any(pilot.lands for pilot in pilots)


def _fits(scene: Scene, scheme: Scheme, terms: Terms, pilots: Sequence[Pilot | WholePilot]) -> bool:
    """Whether a scheme can run a scene, and pilots tell how.

    What sliding does to first order only a run shows.
    """
    slides = terms is ALONE and SCHEMES[scheme].order == 1 and bool(scene.planes)
    suits = scheme == STEADY if remembers(scene) else not (scheme in ADAPTIVE and _contacts_tell(scene, pilots))
    return suits and not slides and not problems(_with(scene, scheme))


def _outdone(tried: Tried, best: Tried) -> Tried:
    """A scheme that would have done, had there not been a cheaper one."""
    if tried.why:
        return tried
    return replace(tried, why=f"costs {tried.cost / best.cost:.2g} times as much")


class _Search:
    """Looks for the pace of each scheme, and remembers the cheapest."""

    def __init__(self, scene: Scene, pilots: Sequence[Pilot | WholePilot], terms: Terms, safe: SafeSteps) -> None:
        self._terms = terms
        self._safe = safe
        self.goal = scene.integrator.goal
        self.best: Tried | None = None
        self._scene = scene
        self._pilots = [pilot for pilot in pilots if pilot.moves]
        self._least = 1
        even = _contacts_tell(scene, self._pilots)
        self._judge = Judge(scene, self._pilots, terms, self._fewest(STEADY) if even else None)
        if even and any(pilot.flown < pilot.frames.max() for pilot in self._pilots):
            self._least = UNSEEN
        self.unknown = self._judge.unknown
        self._margin = SEEN if all(pilot.sees_all for pilot in self._pilots) else MARGIN
        self._frames = max((pilot.flown for pilot in self._pilots), default=1)
        self._tightest = terms.deepest[scene.precision]
        self._stiff = False
        self._told = 0.0

    def of(self, scheme: Scheme) -> Tried:
        """The longest step, or largest tolerance, with which a scheme is accurate enough, if it can be cheapest."""
        if isinstance(SCHEMES[scheme], ClosedForm) or not self._pilots:
            steps = self._fewest(scheme)
            return self._judged(Tried(scheme, steps, None, 0.0, self._cost(scheme, steps), ""))
        last = enough = None
        for each in self._adaptive(scheme) if scheme in ADAPTIVE else self._even(scheme):
            last = each
            if not each.why and each.error is not None and each.error <= self.goal.size / self._margin:
                enough = each
        if enough is not None:
            return self._judged(enough)
        assert last is not None
        if scheme in ADAPTIVE:
            self._told = last.cost
        return last if last.why else replace(last, why="not accurate enough at any pace that was tried")

    def _judged(self, tried: Tried) -> Tried:
        if tried.scheme in ADAPTIVE:
            self._told = tried.cost
        if self.best is None or tried.cost < self.best.cost:
            self.best = tried
        return tried

    def _even(self, scheme: Scheme) -> Iterator[Tried]:
        """Ever more steps, by what the order of the scheme foretells; once they are enough, fewer again."""
        steps, error, order = self._begun(scheme), None, SCHEMES[scheme].order
        too_few, enough = self._fewest(scheme) - 1, 0
        for _ in range(MOST_TRIES):
            price = self._cost(scheme, steps)
            if why := self._hopeless(scheme, steps, price):
                yield Tried(scheme, steps, None, error, price, why)
                return
            error = self._error(lambda pilot, n=steps: pilot.fly(SCHEMES[scheme], steps=n))  # type: ignore[misc]
            self._stiff |= not error < EXPLODED * self.goal.size
            yield Tried(scheme, steps, None, error, price, "")
            excess = error * self._margin / self.goal.size
            if excess > 1.0:
                too_few = steps
            else:
                enough = steps
            foretold = steps * 1.05 * excess ** (1.0 / order) if excess < EXPLODED else math.inf
            if not enough:
                more = math.ceil(min(max(foretold, 1.2 * steps), (8 if excess < EXPLODED else 2) * steps))
                most = self._affordable(scheme)
                steps = int(most) if 1.2 * steps < most < more else more
            elif enough <= max(CLOSE * too_few, too_few + 1):
                return
            else:
                between = max(foretold, math.sqrt(max(too_few, 1) * enough))
                steps = min(math.ceil(min(between, enough / CLOSE)), enough - 1)

    def _begun(self, scheme: Scheme) -> int:
        """Steps to begin with: where an adaptive scheme has told what it takes, a share of that."""
        return max(self._fewest(scheme), int(BEGUN * self._told / self._cost(scheme, 1)))

    def _fewest(self, scheme: Scheme) -> int:
        return self._least * self._safe.fewest(SCHEMES[scheme], self._scene)

    def _affordable(self, scheme: Scheme) -> float:
        """Steps that cost less than the best so far."""
        if self.best is None:
            return math.inf
        none, each = self._cost(scheme, 0), self._cost(scheme, 1) - self._cost(scheme, 0)
        return math.ceil((self.best.cost - none) / each) - 1

    def _hopeless(self, scheme: Scheme, steps: int, price: float) -> str:
        """Why a scheme need not be flown with so many steps, if it need not."""
        solves, evaluations = isinstance(SCHEMES[scheme], ImplicitRungeKutta), SCHEMES[scheme].evaluations
        if self.best is not None and price >= self.best.cost:
            return self._dearer(price)
        many = steps * evaluations * self._frames > (MOST_SOLVED if solves else self._terms.most_calls)
        if many or (not solves and steps * evaluations > self._judge.most_evaluations):
            return f"would need {steps} steps a frame or more"
        return "nothing here is stiff" if solves and self.best is not None and not self._stiff else ""

    def _adaptive(self, scheme: Scheme) -> Iterator[Tried]:
        """Ever smaller tolerances, until they are small enough."""
        if scheme == self._terms.judge and self._judge.spoilt * self._margin > self.goal.size:
            price = self._cost(scheme, self._judge.evaluations / SCHEMES[scheme].evaluations)
            yield Tried(scheme, None, self._tightest, self._judge.spoilt, price, "")
            return
        tolerance, error = LOOSEST, None
        price = self._cost(scheme, 1)
        for _ in range(MOST_TRIES):
            if self.best is not None and price >= self.best.cost:
                yield Tried(scheme, None, tolerance, error, price, self._dearer(price))
                return
            flights = [pilot.fly(SCHEMES[scheme], tolerance=tolerance) for pilot in self._pilots]
            error = self._judge.error(flights)
            evaluations = max(flight.evaluations for flight in flights)
            price = self._cost(scheme, evaluations / SCHEMES[scheme].evaluations)
            dearer = self.best is not None and price >= self.best.cost
            yield Tried(scheme, None, tolerance, error, price, self._dearer(price) if dearer else "")
            excess = error * self._margin / self.goal.size
            halves = max(1, math.floor(2.0 * math.log10(max(excess, 1.0)))) if math.isfinite(excess) else 2
            tolerance = float(f"{tolerance * 10.0 ** (-halves / 2):.1g}")
            if excess <= 1.0 or tolerance < self._tightest:
                return

    def _dearer(self, price: float) -> str:
        assert self.best is not None
        return f"would cost {price / self.best.cost:.2g} times as much as {self.best.scheme} or more"

    def _cost(self, scheme: Scheme, steps: float) -> float:
        return self._terms.cost(SCHEMES[scheme], steps)

    def _error(self, fly: Callable[[Pilot | WholePilot], Flight]) -> float:
        return self._judge.error([fly(pilot) for pilot in self._pilots])


def _with(scene: Scene, scheme: Scheme) -> Scene:
    return scene.model_copy(update={"integrator": Integrator(type=scheme, contact=scene.integrator.contact)})

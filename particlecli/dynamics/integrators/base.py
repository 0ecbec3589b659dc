"""What an integration scheme declares about itself."""

from dataclasses import dataclass
from itertools import product, takewhile
from math import inf, isclose
from typing import Literal

Move = Literal["drift", "kick"]

USUAL_ITERATIONS = 3
"""Newton iterations in a step of an implicit method, the last of which sees that it has converged."""


@dataclass(frozen=True)
class ExplicitRungeKutta:
    """An explicit Runge–Kutta method by its Butcher tableau.

    Attributes:
        order: p: the error after a fixed time falls as dt^p.
        a: strictly lower triangular matrix; row i holds the weights of the slopes before stage i.
        b: weights of the slopes in the step.
        c: times of the stages, in steps.
    """

    order: int
    a: tuple[tuple[float, ...], ...]
    b: tuple[float, ...]
    c: tuple[float, ...]

    symplectic = False
    reversible = False
    l_stable = False
    lane_by_lane = False

    @property
    def evaluations(self) -> int:
        """Force evaluations a step."""
        return len(self.b)


@dataclass(frozen=True)
class Splitting:
    """A composition of exact drifts (x += c h v) and kicks (v += c h a), for forces free of velocity.

    Attributes:
        order: p: the error after a fixed time falls as dt^p.
        moves: the drifts and kicks in the order they are done, each with its share c of the step.
    """

    order: int
    moves: tuple[tuple[Move, float], ...]

    symplectic = True
    l_stable = False
    lane_by_lane = False

    @property
    def reversible(self) -> bool:
        """Whether a step back undoes a step: the composition is a palindrome."""
        return self.moves == self.moves[::-1]

    @property
    def rounds(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """The shares of the kicks, and of the drift that follows each, zero where none does; kicks come first."""
        kicks = tuple(share for kind, share in self.moves if kind == "kick")
        drifts = tuple(share for kind, share in self.moves if kind == "drift")
        return kicks, drifts + (0.0,) * (len(kicks) - len(drifts))

    @property
    def evaluations(self) -> int:
        """Force evaluations a step."""
        return sum(kind == "kick" for kind, _ in self.moves)


@dataclass(frozen=True)
class AdaptiveRungeKutta:
    """An explicit Runge–Kutta method that estimates its error and chooses its step for each particle.

    Attributes:
        order: of the solution that is carried on.
        a, b, c: as of `ExplicitRungeKutta`.
        error: weights of the slopes in the estimate of the local error.
        coarse_error: weights of a second, coarser estimate that tempers the first, as in DOP853.
        exponent, memory: the step changes as error^−exponent × (error of the step before)^memory, Gustafsson's PI
            controller (Hairer & Wanner, Solving Ordinary Differential Equations II, IV.2).
    """

    order: int
    a: tuple[tuple[float, ...], ...]
    b: tuple[float, ...]
    c: tuple[float, ...]
    error: tuple[float, ...]
    coarse_error: tuple[float, ...] | None
    exponent: float
    memory: float

    symplectic = False
    reversible = False
    l_stable = False
    lane_by_lane = True

    @property
    def evaluations(self) -> int:
        """Force evaluations a step."""
        return len(self.b)


@dataclass(frozen=True)
class ImplicitRungeKutta:
    """An implicit Runge–Kutta method by its Butcher tableau.

    Leading stages without weights are explicit; the others are solved for by Newton's method.

    Attributes:
        order: p: the error after a fixed time falls as dt^p.
        a: square matrix; row i holds the weights of the slopes in stage i.
        b: weights of the slopes in the step.
        c: times of the stages, in steps; the sums of the rows of a.
        l_stable: whether decay, however fast, is damped at once.
    """

    order: int
    a: tuple[tuple[float, ...], ...]
    b: tuple[float, ...]
    c: tuple[float, ...]
    l_stable: bool

    lane_by_lane = True

    @property
    def diagonally_implicit(self) -> bool:
        """Whether stages can be solved for one after the other: no slope counts in a stage before its own."""
        return not any(any(row[i + 1 :]) for i, row in enumerate(self.a))

    @property
    def explicit_stages(self) -> int:
        """How many stages at the beginning need no solving."""
        return sum(1 for _ in takewhile(lambda row: not any(row), self.a))

    @property
    def evaluations(self) -> int:
        """Force evaluations a step where Newton's method needs as many iterations as it usually does."""
        return self.explicit_stages + USUAL_ITERATIONS * (len(self.b) - self.explicit_stages)

    @property
    def symplectic(self) -> bool:
        """Whether steps keep phase-space areas: b_i a_ij + b_j a_ji = b_i b_j (Sanz-Serna 1988)."""
        stages = range(len(self.b))
        return all(
            isclose(self.b[i] * self.a[i][j] + self.b[j] * self.a[j][i], self.b[i] * self.b[j])
            for i, j in product(stages, stages)
        )

    @property
    def reversible(self) -> bool:
        """Whether a step back undoes a step: a_(s+1−i)(s+1−j) + a_ij = b_j (Hairer, Lubich & Wanner, V.2)."""
        stages = range(len(self.b))
        return all(isclose(self.a[~i][~j] + self.a[i][j], self.b[j]) for i, j in product(stages, stages))


@dataclass(frozen=True)
class ClosedForm:
    """The solution itself, where the forces of a group have one: steps of any length, wrong by rounding alone."""

    order = inf
    evaluations = 1
    symplectic = True
    reversible = True
    l_stable = True
    lane_by_lane = True


RungeKutta = ExplicitRungeKutta | AdaptiveRungeKutta | ImplicitRungeKutta

AnyScheme = RungeKutta | Splitting | ClosedForm
"""A scheme. Each declares its order and its evaluations of forces in a step; whether it is symplectic, reversible and
L-stable; and whether particles go lane by lane, each in its own way, not in packs."""

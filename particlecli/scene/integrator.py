"""How the motion is advanced in time."""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import AfterValidator, Discriminator, Tag, model_validator

from particlecli.scene.types import Flag, Positive, SceneModel, described

Scheme = Literal[
    "euler",
    "midpoint",
    "rk3",
    "rk4",
    "symplectic_euler",
    "velocity_verlet",
    "yoshida4",
    "composition8",
    "dormand_prince",
    "dop853",
    "implicit_euler",
    "implicit_midpoint",
    "trapezoidal",
    "tr_bdf2",
    "radau_iia",
    "exact",
]
ADAPTIVE: tuple[Scheme, ...] = ("dormand_prince", "dop853")
"""Schemes that choose their step by the estimated error."""

SPLITTINGS: tuple[Scheme, ...] = ("symplectic_euler", "velocity_verlet", "yoshida4", "composition8")
"""Schemes that advance positions and velocities in turn."""

Method = Literal[Scheme, "auto"]
"""A scheme, or the choice of one."""

SCHEMES_TOLD = (
    "scheme, here with its order. Explicit: euler 1, midpoint 2, rk3 3, rk4 4. Adaptive, at the pace of the estimated "
    "error: dormand_prince 5, dop853 8. Splittings, under which energy does not drift, and of which all but the first "
    "want forces free of velocity: symplectic_euler 1, velocity_verlet 2, yoshida4 4, composition8 8. Implicit, for "
    "stiff forces: implicit_euler 1, implicit_midpoint 2, trapezoidal 2, tr_bdf2 (bdf2 in one step) 2, radau_iia 5. "
    "exact: the solution in closed form, where there is one. auto: the cheapest scheme and step that short pilots on "
    "a sample find to be accurate enough"
)

UNCHOSEN: Scheme = "rk4"
"""What plans of a scene are made with as long as `auto` has not chosen."""

DEFAULT_STEP = 0.005
DEFAULT_TOLERANCE = 1e-6
DEFAULT_GOAL = "0.5 px"

ContactScheme = Literal["located", "end_of_step"]


PIXELS = " px"


def _pixels(text: str) -> str:
    try:
        size = float(text.removesuffix(PIXELS)) if text.endswith(PIXELS) else 0.0
    except ValueError:
        size = 0.0
    if not 0.0 < size < math.inf:
        raise ValueError('must be a positive number, of metres, or of pixels as in "0.5 px"')
    return text


Pixels = Annotated[str, AfterValidator(_pixels)]
"""A length on the picture, as in "0.5 px"."""


Tolerance = Annotated[
    Annotated[Positive, Tag("metres")] | Annotated[Pixels, Tag("pixels")],
    Discriminator(lambda value: "pixels" if isinstance(value, str) else "metres"),
]


class Goal(NamedTuple):
    """An error asked for: 95 in 100 particles are to be at most this far off at any time."""

    size: float
    unit: Literal["m", "px"]


class Integrator(SceneModel):
    """The integration scheme and its largest step; a frame is cut into equal steps no longer than it."""

    type: Method = described(SCHEMES_TOLD, default="auto")
    dt: Positive | None = described(
        "largest time step, s; none: 0.005 s, as the error allows where the scheme is adaptive or chosen, or the "
        "whole frame where it is exact and there are no planes",
        default=None,
    )
    tolerance: Tolerance | None = described(
        "error that an adaptive scheme may make in a step, in m and m/s, and relative to coordinates and speeds "
        'above 1; none: 1e-6. Of auto: the error of positions asked for, in m, or on the picture, as in "0.5 px"; '
        "none: 0.5 px",
        default=None,
    )
    contact: ContactScheme = described(
        "located: impacts on planes happen at their instant within the step; of particles that act on each other, "
        "the step of all is cut there. end_of_step: the classic course's scheme, which corrects what is found below a "
        "plane after each step; quicker where many meet planes. It is the only one for planes that ride on moving "
        "frames, and of particles that act on each other for many (over 512), for implicit schemes and for forces "
        "between neighbours and by a tree; `explain` and every run tell which one a group has",
        default="located",
    )
    allow_unstable: Flag = described(
        "run even where the step is so long that the scheme lets motion grow that should not", default=False
    )

    @model_validator(mode="after")
    def _tolerated(self) -> Self:
        if self.tolerance is not None and self.type not in (*ADAPTIVE, "auto"):
            raise ValueError(
                f"`tolerance` is for auto and for adaptive schemes ({', '.join(ADAPTIVE)}); {self.type} takes `dt`"
            )
        if isinstance(self.tolerance, str) and self.type != "auto":
            raise ValueError(f"a tolerance in pixels is for auto; {self.type} takes m and m/s")
        return self

    @property
    def scheme(self) -> Scheme:
        """The scheme; of `auto`, as long as it has not chosen, the one that plans are made with."""
        return UNCHOSEN if self.type == "auto" else self.type

    @property
    def adaptive(self) -> bool:
        """Whether the scheme chooses its step."""
        return self.type in ADAPTIVE

    @property
    def local_tolerance(self) -> float:
        """The error that an adaptive scheme may make in a step, m or m/s."""
        return self.tolerance if isinstance(self.tolerance, float) else DEFAULT_TOLERANCE

    @property
    def goal(self) -> Goal:
        """The error that is asked of `auto`."""
        if isinstance(self.tolerance, float):
            return Goal(self.tolerance, "m")
        return Goal(float((self.tolerance or DEFAULT_GOAL).removesuffix(PIXELS)), "px")

    @property
    def longest_step(self) -> float:
        """The largest time step, s; infinite where only the error limits it."""
        return self.dt or (math.inf if self.adaptive else DEFAULT_STEP)

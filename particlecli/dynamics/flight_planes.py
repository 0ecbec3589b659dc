"""Planes that flights meet: where within a step they do, and what becomes of a state there."""

import taichi as ti

NORMAL, OFFSET, RESTITUTION, HOLDS, COULOMB, VISCOUS = 0, 3, 4, 5, 6, 7
"""Columns of planes: normal, its product with a point of the plane, …, whether a hit ends the motion, …"""

MOST_IMPACTS = 4
"""Impacts within a step that are followed; what is still below then comes to rest on the plane."""

CORRECTIONS = 2
"""Newton steps towards the instant of an impact."""

Search = ti.types.struct(
    trial=ti.i32,  # number of the trial step towards an impact that is sought; 0: none is
    struck=ti.i32,  # the plane
    when=ti.f64,  # length of the next trial, s
    reach=ti.f64,  # of the step in which the impact was found, s
    impacts=ti.i32,  # in this step so far
)
"""An impact being looked for within a step."""


@ti.data_oriented
class FlightPlanes:
    """Planes as rows of a table, see `NORMAL` and so on.

    Args:
        components: of motion, 3 or 6.
    """

    def __init__(self, components: int) -> None:
        self.components = components

    @ti.func
    def height(self, planes: ti.template(), k, y):
        """Above a plane, m, and its rate of change, m/s; what has no velocity always goes down."""
        height, speed = -planes[k, OFFSET], 0.0 * y[0]
        for c in ti.static(range(3)):
            height += planes[k, NORMAL + c] * y[c]
            speed += planes[k, NORMAL + c] * y[c + 3]
        if ti.static(self.components == 3):
            speed = -1.0
        return height, speed

    @ti.func
    def hit(self, planes: ti.template(), k, y, rests):
        """A state put onto a plane, and turned round or stopped."""
        height, speed = self.height(planes, k, y)
        after = y
        impulse = ti.max(0.0, -(1.0 + (0.0 if rests else planes[k, RESTITUTION])) * speed)
        along = 0.0 * y[0]
        for c in ti.static(range(3)):
            after[c] = y[c] - height * planes[k, NORMAL + c]
            along += (y[c + 3] + impulse * planes[k, NORMAL + c]) * planes[k, NORMAL + c]
        sliding = ti.Vector([y[c + 3] + (impulse - along) * planes[k, NORMAL + c] for c in range(3)])
        kept = ti.max(0.0, 1.0 - planes[k, COULOMB] * impulse / (sliding.norm() + 1e-300))
        kept = kept * ti.exp(-planes[k, VISCOUS] * impulse)
        if ti.static(self.components == 6):
            for c in ti.static(range(3)):
                turned = along * planes[k, NORMAL + c] + kept * sliding[c]
                after[c + 3] = ti.select(planes[k, HOLDS] > 0.0, 0.0, turned)
        return after

    @ti.func
    def passed(self, planes: ti.template(), count, located, search: ti.template(), old, new, h, held):
        """What a step of length h from a state to a new one comes to among the first `count` planes.

        Args:
            located: whether impacts happen within the step, or at its end.
            search: goes on.
            held: whether a plane holds what flies.

        Returns:
            The state, how long the way to it takes, s, nothing while an impact is sought; and as `held`.
        """
        after, moved, holds = old, 0.0 * h, held
        deepest = 0.0 * h
        if (search.trial == 0) & (located == 1) & (search.impacts < MOST_IMPACTS):
            deepest, search.struck = self.lowest(planes, count, new)
        if deepest < 0.0:
            search.when, search.reach = self.due(planes, search.struck, old, deepest, h), h
            search.trial = 1
        elif search.trial == 0:
            after, holds = self.met(planes, count, new, held, located == 1)
            moved, search.impacts = h, 0
        elif search.trial <= CORRECTIONS:
            search.when = self.corrected(planes, search.struck, new, search.when, search.reach)
            search.trial += 1
        else:
            after = self.hit(planes, search.struck, new, False)
            holds = planes[search.struck, HOLDS] > 0.0
            moved, search.trial = h, 0
            search.impacts = search.impacts + 1 if h > 0.0 else MOST_IMPACTS
        return after, moved, holds

    @ti.func
    def lowest(self, planes: ti.template(), count, y):
        """The plane of the first `count` that a state has got furthest below, and how deep, m; 0 if below none."""
        deepest, struck = 0.0 * y[0], 0
        for k in range(count):
            height, speed = self.height(planes, k, y)
            if (speed < 0.0) & (height < deepest):
                deepest, struck = height, k
        return deepest, struck

    @ti.func
    def due(self, planes: ti.template(), k, y, deepest, h):
        """When a step of length h from a state comes to plane k, below which it ends by `deepest`."""
        before, rising = self.height(planes, k, y)
        return h * crossing(ti.max(before, 0.0), h * rising, deepest)

    @ti.func
    def corrected(self, planes: ti.template(), k, y, when, reach):
        """A step of Newton's method towards the instant of an impact, between 0 and `reach`."""
        height, speed = self.height(planes, k, y)
        return ti.min(ti.max(when - height / ti.select(speed < 0.0, speed, -1.0), 0.0), reach)

    @ti.func
    def met(self, planes: ti.template(), count, y, held, rests):
        """A state put onto planes that it is below, heading in; and whether one of them holds it."""
        after, holds = y, held
        for k in range(count):
            height, speed = self.height(planes, k, after)
            if (height < 0.0) & (speed < 0.0) & (not holds):
                after = self.hit(planes, k, after, rests)
                holds = planes[k, HOLDS] > 0.0
        return after, holds


@ti.func
def crossing(above, rise, below):
    """Where in a step a height, c ≥ 0 at first and d < 0 at last, is zero: of the parabola that begins with a slope."""
    bend = below - above - rise
    root = ti.sqrt(ti.max(rise * rise - 4.0 * bend * above, 0.0))
    share = 2.0 * above / ti.max(root - rise, 1e-300)
    if rise > 0.0:
        share = (rise + root) / ti.max(-2.0 * bend, 1e-300)
    return ti.min(ti.max(share, 0.0), 1.0)

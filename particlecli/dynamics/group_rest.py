"""The packs of a group in which particles rest: they go on resting together, instead of one by one."""

import taichi as ti

from particlecli.dynamics.algebra import finite
from particlecli.dynamics.group_plan import LANES
from particlecli.dynamics.march import Way
from particlecli.dynamics.outcome import RESTING

LEAST = 32
"""So many particles resting in the frame before make it worth while to look for packs of them."""

WORTH = 2e7
"""So many steps of resting particles, taken one by one, last as long as the kernel takes to compile for one plane."""


@ti.data_oriented
class GroupRest:
    """A kernel for packs of which several particles rest on planes.

    It does for those what the careful march would do, to the last bit, so it does not matter which of the two a
    particle meets with.

    The kernel is compiled once as much time has been spent on resting particles one by one as that takes.

    Args:
        group: the group.
    """

    def __init__(self, group) -> None:
        self.group = group
        self._resting = 0
        self._spent = 0.0

    @property
    def pays(self) -> bool:
        """Whether to look for packs."""
        return self._resting >= LEAST and self._spent >= WORTH * len(self.group.march.contacts)

    def learn(self, resting: int, steps: int) -> None:
        """Take note that so many particles lay on planes at the beginning of so many steps."""
        self._resting = resting
        self._spent += resting * steps

    @ti.kernel
    def advance_calmly(
        self,
        packs: ti.i32,
        count: ti.i32,
        start: ti.f64,
        interval: ti.f64,
        steps: ti.i32,
        flags: ti.types.ndarray(dtype=ti.i32, ndim=1),
    ):
        """March packs again in which two or more particles lie on planes, and keep those that nothing happens to."""
        for b in range(packs):
            bits = self.group.below[b]
            if bits & (bits - 1) != 0:
                lying = self._lying(b, bits)
                if lying & (lying - 1) != 0:
                    self.group.below[b] = bits ^ self._advance_pack(b, lying, count, start, interval, steps, flags)

    @ti.func
    def _lying(self, b, bits):
        """Bits of the lanes that lie on a plane, of those given."""
        x = [self.group.state.reals[c, b] for c in ti.static(range(3))]
        lies = ti.select(self.group.march.careful_stepper.events.lies(self.group.loaded(), x), 1, 0)
        lying = 0
        for lane in ti.static(range(LANES)):
            lying |= lies[lane] << lane
        return lying & bits

    @ti.func
    def _advance_pack(self, b, lying, count, start, interval, steps, flags: ti.template()):
        """Bits of the lanes that are done."""
        new = self.group.marched(b, start, interval, steps, Way.CALMLY)
        lanes = ti.Vector(list(range(LANES)))
        calm = (new[8] >= 0.0) & finite(new[:6]) & (((lying >> lanes) & 1) == 1)
        for i in ti.static(range(len(self.group.plan.motion_components))):
            self.group.state.reals[i, b] = ti.select(calm, new[i], self.group.state.reals[i, b])
        self.group.keep(b, count, calm, new[6], new[7], new[9], flags)
        done, number = 0, 0
        for lane in ti.static(range(LANES)):
            if calm[lane]:
                done |= 1 << lane
                number += 1
        ti.atomic_add(flags[RESTING], number)
        return done

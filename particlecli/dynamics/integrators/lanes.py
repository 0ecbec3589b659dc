"""Steppers that take packs lane by lane: written out for packs they would take LLVM many times longer to compile."""

import taichi as ti


@ti.data_oriented
class LaneByLane:
    """Takes each lane of a pack, or a scalar, through the step of a stepper for scalars."""

    def __init__(self, stepper) -> None:
        self.stepper = stepper

    @ti.func
    def step(self, p, state, t, h, body):
        """The state after a step of length h from time t."""
        if ti.static(not is_pack(state[0])):
            return self.stepper.step(p, state, t, h, body)
        x, y, z, u, v, w = state[0], state[1], state[2], state[3], state[4], state[5]
        for lane in range(state[0].n):
            here = [of_lane(state[c], lane) for c in ti.static(range(6))]
            own = [of_lane(body[j], lane) for j in ti.static(range(len(body)))]
            new = self.stepper.step(p, here, of_lane(t, lane), of_lane(h, lane), own)
            x[lane], y[lane], z[lane] = new[0], new[1], new[2]
            u[lane], v[lane], w[lane] = new[3], new[4], new[5]
        return [x, y, z, u, v, w]


@ti.func
def of_lane(value, lane):
    """The value of one lane of a pack; a scalar itself."""
    if ti.static(is_pack(value)):
        return value[lane]
    return value


def is_pack(value):
    """Whether a value of the kernel has lanes."""
    return value.is_tensor()

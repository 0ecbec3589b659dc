"""Copying particles between NumPy arrays and packs, and closing the gaps that the dead leave.

A launch takes longer than copying a few thousand particles, so each kernel does all components at once, and where
there are `few` particles in one thread.
"""

import taichi as ti

from particlecli.dynamics.group_plan import LANES

Integers = ti.types.ndarray(dtype=ti.i32, ndim=1)
IntegerRows = ti.types.ndarray(dtype=ti.i32, ndim=2)
RealRows = ti.types.ndarray(ndim=2)


@ti.kernel
def copy_in(
    reals: ti.template(), integers: ti.template(), first: ti.i32, new_reals: RealRows, new_integers: IntegerRows,
    few: ti.template(),
):  # fmt: skip
    """Put particles, shapes (components, count), behind the `first` ones."""
    ti.loop_config(serialize=few)
    for i in range(new_reals.shape[1]):
        b, lane = (first + i) // LANES, (first + i) % LANES
        for row in range(new_reals.shape[0]):
            reals[row, b][lane] = new_reals[row, i]
        for row in range(new_integers.shape[0]):
            integers[row, b][lane] = new_integers[row, i]


@ti.kernel
def overwrite_row(reals: ti.template(), row: ti.i32, values: ti.types.ndarray(ndim=1)):
    """Replace one real component of all particles."""
    for i in range(values.shape[0]):
        reals[row, i // LANES][i % LANES] = values[i]


@ti.func
def _row(bits, place):
    """The row that comes at a place among those whose bits are set."""
    row, left = 0, place
    while (left > 0) | ((bits >> row) & 1 == 0):
        left -= (bits >> row) & 1
        row += 1
    return row


@ti.func
def _copy_lanes(field: ti.template(), row, place, b, count, values: ti.template()):
    for i in range(b * LANES, ti.min((b + 1) * LANES, count)):
        values[place, i] = field[row, b][i % LANES]


@ti.func
def _copy_pack(field: ti.template(), row, place, b, count, values: ti.template(), few: ti.template()):
    if ti.static(few):
        _copy_lanes(field, row, place, b, count, values)
    elif (b + 1) * LANES <= count:  # straight-line code runs faster, but takes long to trace
        pack = field[row, b]
        for lane in ti.static(range(LANES)):
            values[place, b * LANES + lane] = pack[lane]
    else:
        _copy_lanes(field, row, place, b, count, values)


@ti.kernel
def copy_out(
    reals: ti.template(), integers: ti.template(), count: ti.i32, real_bits: ti.i32, integer_bits: ti.i32,
    real_values: RealRows, integer_values: IntegerRows, few: ti.template(),
):  # fmt: skip
    """Copy those components of `count` particles whose rows' bits are set, in the order of the rows."""
    packs = (count + LANES - 1) // LANES
    ti.loop_config(serialize=few)
    for task in range((real_values.shape[0] + integer_values.shape[0]) * packs):
        place, b = task // packs, task % packs
        if place < real_values.shape[0]:
            _copy_pack(reals, _row(real_bits, place), place, b, count, real_values, few)
        else:
            place = place - real_values.shape[0]
            _copy_pack(integers, _row(integer_bits, place), place, b, count, integer_values, few)


@ti.kernel
def compress(
    reals: ti.template(), integers: ti.template(), real_rows: ti.i32, integer_rows: ti.i32, fates: ti.i32,
    count: ti.i32, tally: Integers,
):  # fmt: skip
    """Close up the particles that live, in order; count those and the dead by cause. Row `fates` tells who lives."""
    ti.loop_config(serialize=True)
    for _ in range(1):
        kept = 0
        for i in range(count):
            fate = integers[fates, i // LANES][i % LANES]
            cause = ti.max(fate, 0)
            tally[cause] = tally[cause] + 1
            if fate <= 0:
                if kept < i:
                    for row in range(real_rows):
                        reals[row, kept // LANES][kept % LANES] = reals[row, i // LANES][i % LANES]
                    for row in range(integer_rows):
                        integers[row, kept // LANES][kept % LANES] = integers[row, i // LANES][i % LANES]
                kept = kept + 1

"""Sorting bodies by the tiles that they touch, and those of a tile by depth."""

import taichi as ti

from particlecli.render.solids.records import DEPTH, EXTENT, HEAD, X, Y
from particlecli.render.solids.tiles import TILE
from particlecli.render.tasks import CHUNK

DIGITS = 256
"""Keys are sorted by two digits of 8 bits."""

FEW = 24
"""Heads that are sorted by insertion."""

_KEYS = DIGITS * DIGITS

_STEP = 11
"""Bits of a depth's mantissa that do not matter for its key: depths that differ by less than 1/4096 may be alike."""


@ti.func
def key_of(depth, near):
    """Place of a depth in the order from near to far, 0 to 65535."""
    steps = (ti.bit_cast(ti.cast(depth, ti.f32), ti.i32) - ti.bit_cast(ti.cast(near, ti.f32), ti.i32)) >> _STEP
    return ti.min(ti.max(steps, 0), _KEYS - 1)


@ti.func
def tiles_across(size):
    """How many tiles cover so many pixels."""
    return (size + TILE - 1) // TILE


@ti.func
def _touched(middle, extent, tiles):
    """First tile, and the one behind the last, along an axis that something touches; the same where it touches none."""
    first = ti.max(ti.cast(ti.floor((middle - extent) * (1.0 / TILE)), ti.i32), 0)
    end = ti.min(ti.cast(ti.floor((middle + extent) * (1.0 / TILE)), ti.i32) + 1, tiles)
    return first, ti.max(first, end)


@ti.func
def take_to_tiles(
    chunk, count, heads: ti.template(), counts: ti.template(), sorted_heads: ti.template(), across, down,
    placing: ti.template(),
):  # fmt: skip
    """Count a chunk's bodies by the tiles that they touch, or copy their heads to where the counts say."""
    start = chunk * across * down
    for body in range(chunk * CHUNK, ti.min(count, chunk * CHUNK + CHUNK)):
        extent = heads[body, EXTENT]
        if extent > 0.0:
            left, right = _touched(heads[body, X], extent, across)
            top, bottom = _touched(heads[body, Y], extent, down)
            for y in range(top, bottom):
                for x in range(left, right):
                    tile = start + y * across + x
                    place = counts[tile]
                    counts[tile] = place + 1
                    if ti.static(placing):
                        for k in ti.static(range(HEAD)):
                            sorted_heads[place, k] = heads[body, k]


@ti.func
def _sort_few(first, end, near, heads: ti.template(), keys: ti.template(), order: ti.template()):
    """Sort a few heads by insertion; see `sort_by_depth`."""
    for o in range(first, end):
        key = key_of(heads[o, DEPTH], near)
        keys[o] = key
        place = o
        while place > first and keys[order[1, place - 1]] > key:
            order[1, place] = order[1, place - 1]
            place -= 1
        order[1, place] = o


@ti.func
def _sort_many(
    first, end, near, worker, heads: ti.template(), keys: ti.template(), digits: ti.template(), order: ti.template()
):  # fmt: skip
    """Sort heads digit by digit; see `sort_by_depth`.

    Depths are read out of the heads one after the other: so these come into the cache faster than if they came in the
    order of their depths.
    """
    for digit in range(2 * DIGITS):
        digits[worker, digit] = 0
    for o in range(first, end):
        key = key_of(heads[o, DEPTH], near)
        keys[o] = key
        low, high = key & (DIGITS - 1), DIGITS + (key >> 8)
        digits[worker, low] = digits[worker, low] + 1
        digits[worker, high] = digits[worker, high] + 1
    low, high = first, first
    for digit in range(DIGITS):
        here, there = digits[worker, digit], digits[worker, DIGITS + digit]
        digits[worker, digit], digits[worker, DIGITS + digit] = low, high
        low, high = low + here, high + there
    for o in range(first, end):
        digit = keys[o] & (DIGITS - 1)
        place = digits[worker, digit]
        digits[worker, digit] = place + 1
        order[0, place] = o
    for o in range(first, end):
        head = order[0, o]
        digit = DIGITS + (keys[head] >> 8)
        place = digits[worker, digit]
        digits[worker, digit] = place + 1
        order[1, place] = head


@ti.func
def sort_by_depth(
    first, end, near, worker, heads: ti.template(), keys: ti.template(), digits: ti.template(), order: ti.template()
):  # fmt: skip
    """Sort a tile's heads from near to far; those of the same key keep their order. The result is in order[1]."""
    if end - first > FEW:
        _sort_many(first, end, near, worker, heads, keys, digits, order)
    else:
        _sort_few(first, end, near, heads, keys, order)

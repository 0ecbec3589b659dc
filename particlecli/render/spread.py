"""Between the levels of a pyramid: halos and bloom spread up to coarser levels, light comes down again."""

import taichi as ti

from particlecli.render.arrays import IntegerTable, Row, vec4
from particlecli.render.colour import LUMINANCE
from particlecli.render.layout import HEIGHT, MARGIN, OFFSET, PITCH, SHIFT, WIDTH
from particlecli.render.tasks import CHUNK

CARRIED = 0.7071
"""Share of a halo's light that goes on to the next level; its brightness then falls as distance^-2.5."""

REACH = 3
"""Nodes outside the picture whose light still comes back into it."""

_WIDE = 0.75, 0.125
"""Shares of a node and of the next but one that halving gives to a node, next to ½ of its neighbours: a cubic B-spline,
which keeps halos in shape."""

_NARROW = 1.0, 0.0
"""Enough for the finest levels, on which a splat gives half of its light to every other node."""

NARROW_LEVELS = 2
"""How many levels those are."""

_R, _G, _B = (float(component) for component in LUMINANCE)


@ti.func
def halo_share(here):
    """The share of a node's light that has a halo, from the luminance that is marked for halos."""
    share = 0.0
    if here[3] > 0.0:
        luminance = _R * here[0] + _G * here[1] + _B * here[2]
        share = ti.min(here[3] / ti.max(luminance, 1e-20), 1.0)
    return share


@ti.func
def refined(light: ti.template(), node, pitch, odd):
    """One column of the next coarser level at the height of a row, for cubic B-spline subdivision.

    `node` is the uppermost of the three rows that count for an even row, or of the two for an odd one.
    """
    middle = ti.select(odd, 0.5, 0.75)
    upper = ti.select(odd, 0.5, 0.125)
    lower = ti.select(odd, 0.0, 0.125)
    return upper * light[node] + middle * light[node + pitch] + lower * light[node + 2 * pitch]


@ti.func
def _leaving(
    light: ti.template(), halo: ti.template(), bloom: ti.template(), node, first, share,
    finest: ti.template(),
):  # fmt: skip
    """Halo and bloom that go on from a node, which has those that came at `node − first`; none came to the finest."""
    here = light[node]
    onwards = here * halo_share(here)
    scattered = share * (here - onwards)
    if ti.static(not finest):
        arrived = halo[node - first]
        onwards = onwards + CARRIED * arrived
        scattered = scattered + bloom[node - first] + (share * (1.0 - CARRIED)) * arrived
    return onwards, scattered


@ti.func
def _column(
    light: ti.template(), halo: ti.template(), bloom: ti.template(), node, pitch, first, share, middle, outer,
    finest: ti.template(),
):  # fmt: skip
    """Halo and bloom that go on from nodes above each other, weighted."""
    wide, lens = _leaving(light, halo, bloom, node, first, share, finest)
    wide, lens = middle * wide, middle * lens
    for k in ti.static((-1, 1)):
        onwards, scattered = _leaving(light, halo, bloom, node + k * pitch, first, share, finest)
        wide, lens = wide + 0.5 * onwards, lens + 0.5 * scattered
    if ti.static(not finest):
        for k in ti.static((-2, 2)):
            onwards, scattered = _leaving(light, halo, bloom, node + k * pitch, first, share, finest)
            wide, lens = wide + outer * onwards, lens + outer * scattered
    return wide, lens


@ti.func
def _widen_row(
    row, level, light: ti.template(), halo: ti.template(), bloom: ti.template(), levels: ti.template(),
    stays: ti.template(), share, finest: ti.template(),
):  # fmt: skip
    """Halve a level's halo and bloom into one row of the next; the weights keep light and centroids."""
    first, pitch = levels[level, SHIFT], levels[level, PITCH]
    width, goes_on = levels[level + 1, WIDTH], 1.0 - stays[level]
    middle, outer = _NARROW[0], _NARROW[1]
    if level >= NARROW_LEVELS:
        middle, outer = _WIDE[0], _WIDE[1]
    y = MARGIN - REACH + row
    node = levels[level, OFFSET] + (2 * y - MARGIN) * pitch + MARGIN - 2 * REACH
    target = levels[level + 1, OFFSET] - first + y * levels[level + 1, PITCH] + MARGIN - REACH
    a, p = _column(light, halo, bloom, node - 2, pitch, first, share, middle, outer, finest)
    b, q = _column(light, halo, bloom, node - 1, pitch, first, share, middle, outer, finest)
    c, r = _column(light, halo, bloom, node, pitch, first, share, middle, outer, finest)
    for i in range(width + 2 * REACH):
        here = node + 2 * i
        d, s = _column(light, halo, bloom, here + 1, pitch, first, share, middle, outer, finest)
        e, t = _column(light, halo, bloom, here + 2, pitch, first, share, middle, outer, finest)
        halo[target + i] = 0.5 * (b + d) + middle * c + outer * (a + e)
        a, b, c = c, d, e
        bloom[target + i] = (0.5 * (q + s) + middle * r + outer * (p + t)) * goes_on
        p, q, r = r, s, t


@ti.func
def _settled(
    light: ti.template(), halo: ti.template(), bloom: ti.template(), node, first, share, settling, carried,
    finest: ti.template(),
):  # fmt: skip
    """What a level holds at a node once halos and bloom are spread."""
    here = light[node]
    settled = here - here * halo_share(here)
    if ti.static(not finest):
        settled = settled + (1.0 - carried) * halo[node - first]
    scattered = share * settled
    if ti.static(not finest):
        scattered = scattered + bloom[node - first]
    return settled * (1.0 - share) + scattered * settling


@ti.func
def _gather_row(
    row, level, last, light: ti.template(), halo: ti.template(), bloom: ti.template(), levels: ti.template(),
    stays: ti.template(), share, finest: ti.template(),
):  # fmt: skip
    """Settle one row of a level: its own light, its part of halos and bloom, and what coarser levels hold.

    A coarser node spreads its light over finer ones with weights 1 4 6 4 1 (/16) along each axis.
    """
    first = levels[level, SHIFT]
    y = MARGIN - REACH + row
    node = levels[level, OFFSET] + y * levels[level, PITCH] + MARGIN - REACH - 1
    odd = y % 2 == 1
    settling, carried, pitch, above = 1.0, 0.0, 0, 0
    left, middle, right = vec4(0.0), vec4(0.0), vec4(0.0)
    if level < last:
        settling, carried = stays[level], CARRIED
        pitch = levels[level + 1, PITCH]
        above = levels[level + 1, OFFSET] + ((y + MARGIN) // 2 - ti.select(odd, 0, 1)) * pitch
        above = above + MARGIN - (REACH + 1) // 2
        left = refined(light, above - 1, pitch, odd)
        middle = refined(light, above, pitch, odd)
    for i in range((levels[level, WIDTH] + 2 * REACH) // 2 + 1):
        if level < last:
            right = refined(light, above + i + 1, pitch, odd)
        here = node + 2 * i
        own = _settled(light, halo, bloom, here, first, share, settling, carried, finest)
        light[here] = own + 0.25 * (0.125 * (left + right) + 0.75 * middle)
        own = _settled(light, halo, bloom, here + 1, first, share, settling, carried, finest)
        light[here + 1] = own + 0.125 * (middle + right)
        left = middle
        middle = right


@ti.kernel
def clear(light: ti.template(), first: ti.i32, end: ti.i32):
    """Take all light away from a range of nodes."""
    ti.loop_config(block_dim=1)
    for chunk in range((end - first + CHUNK - 1) // CHUNK):
        start = first + chunk * CHUNK
        for node in range(start, ti.min(start + CHUNK, end)):
            light[node] = vec4(0.0)


@ti.kernel
def widen(
    level: ti.i32, light: ti.template(), halo: ti.template(), bloom: ti.template(),
    levels: IntegerTable, stays: Row, share: ti.f32, finest: ti.template(),
):  # fmt: skip
    """Spread the halos and the bloom of one level into the next; see `Pyramid.collapse`."""
    rows = levels[level + 1, HEIGHT] + 2 * REACH
    ti.loop_config(block_dim=1)
    for row in range(rows):
        _widen_row(row, level, light, halo, bloom, levels, stays, share, finest)


@ti.kernel
def gather(
    level: ti.i32, last: ti.i32, light: ti.template(), halo: ti.template(), bloom: ti.template(),
    levels: IntegerTable, stays: Row, share: ti.f32, finest: ti.template(),
):  # fmt: skip
    """Settle one level, once all coarser ones, to the last, are."""
    rows = levels[level, HEIGHT] + 2 * REACH
    ti.loop_config(block_dim=1)
    for row in range(rows):
        _gather_row(row, level, last, light, halo, bloom, levels, stays, share, finest)


@ti.kernel
def settle_small(
    level: ti.i32, last: ti.i32, light: ti.template(), halo: ti.template(), bloom: ti.template(),
    levels: IntegerTable, stays: Row, share: ti.f32,
):  # fmt: skip
    """Widen and gather the levels from `level`, 1 or more, to the last, too small to be shared out."""
    ti.loop_config(serialize=True)
    for _ in range(1):
        for fine in range(level, last):
            for row in range(levels[fine + 1, HEIGHT] + 2 * REACH):
                _widen_row(row, fine, light, halo, bloom, levels, stays, share, False)
        for step in range(last - level + 1):
            fine = last - step
            for row in range(levels[fine, HEIGHT] + 2 * REACH):
                _gather_row(row, fine, last, light, halo, bloom, levels, stays, share, False)

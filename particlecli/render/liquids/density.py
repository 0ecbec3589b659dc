"""The density of blobs along the rays of a band of rows, PACK pixels at once.

All blobs of a group add up, F = Σ (1 − q)⁸. Where they are as dense as one blob is at its radius, F = τ⁸, is the
surface. A band goes through its blobs a few times: `enter` finds where rays meet the first blob, from where `climb`
takes steps of a Newton scheme to the surface, for which `gather` adds up the density. It solves G = τ for G = F^(1/8),
which is the parabola 1 − q along a ray through one blob, and close to one through many.
"""

import taichi as ti

from particlecli.render.liquids.records import (
    BLUE,
    DEPTH,
    EX,
    EY,
    EZ,
    GREEN,
    HX,
    HY,
    MXX,
    MXY,
    MYY,
    RED,
    SHARE,
    C,
    X,
    Y,
)

PACK = 16
"""Pixels beside each other that are taken at once."""

NEAR, OWN, F, SLOPE, BEND, ACROSS, DOWN, SHARES, REDS, GREENS, BLUES = range(11)
"""What a band keeps for each pixel: the depth from where to climb, and that of the first blob that is met for itself,
m; F and its derivatives by depth; Σ (1 − q)⁷ ∂q of the others; shares and tints, Σ F."""

CELLS = 11

FAR = 1e30
"""Depth where nothing is."""

PATIENCE = 4
"""After so many visits each it is looked up how far the rays of a pack go."""

LONG = 0.35
"""Steps that are longer are looked at again, in lengths over which the parabola falls by a half."""

LOWEST = 1 / 3
"""Rays that meet less than this share of the density of the surface in each blob do not look for one there."""

Single = ti.types.vector(PACK, ti.f32)


@ti.func
def _outline(mxx, mxy, myy):
    """Where a blob ends: on a line dy below its middle it is within √(narrowing dy² + square) of its x − lean dy."""
    lean, inverse = 0.5 * mxy / mxx, 1.0 / mxx
    return lean, lean * lean - myy * inverse, inverse


@ti.func
def _span(x, dy, lean, narrowing, square, packs):
    """First and last pack of a line that a blob reaches into, `dy` pixels below its middle."""
    middle, wide = x - lean * dy, ti.sqrt(ti.max(narrowing * dy * dy + square, 0.0))
    left = ti.max(ti.cast(ti.ceil(middle - wide), ti.i32), 0) // PACK
    right = ti.min(ti.cast(ti.floor(middle + wide), ti.i32), packs * PACK - 1) // PACK
    if middle + wide < 0.0:
        right = -1
    return left, right


@ti.func
def _beside(x, pack):
    """How far the pixels of a pack are to the right of x."""
    return ti.Vector([ti.cast(i, ti.f32) for i in range(PACK)]) + (pack * PACK - x)


@ti.func
def farthest_of(depths):
    """The farthest depth of a pack."""
    most = depths[0]
    for i in ti.static(range(1, PACK)):
        most = ti.max(most, depths[i])
    return most


@ti.func
def hidden(row, rows: ti.template(), packs, worker, limits: ti.template()):
    """Whether all of a blob is farther than what the rays of a band look for where it is."""
    left = ti.max(ti.cast(ti.ceil(rows[row, X] - rows[row, EX]), ti.i32), 0) // PACK
    right = ti.min(ti.cast(ti.floor(rows[row, X] + rows[row, EX]), ti.i32) // PACK, packs - 1)
    limit = -FAR
    for pack in range(left, right + 1):
        limit = ti.max(limit, limits[worker, pack])
    return limit <= rows[row, DEPTH] - rows[row, EZ]


@ti.func
def limit_of(pack, packs, lines, worker, farthest: ti.template()):
    """The farthest depth up to which the packs above each other in a band look."""
    limit = -FAR
    for line in range(lines):
        limit = ti.max(limit, farthest[worker, line * packs + pack])
    return limit


@ti.func
def enter(
    row, rows: ti.template(), top, bottom, packs, worker, cells: ti.template(), farthest: ti.template(),
    visits: ti.template(), limits: ti.template(), radius, lowest,
):  # fmt: skip
    """Take a blob for where rays first meet one; `radius` and `lowest` are q on the surface and where it is too thin.

    Blobs come from near to far. Where all rays of a pack have met blobs, what is farther than those is passed by.
    """
    depth, c, hx, hy = rows[row, DEPTH], rows[row, C], rows[row, HX], rows[row, HY]
    mxx, mxy, myy = rows[row, MXX], rows[row, MXY], rows[row, MYY]
    x, y = rows[row, X], rows[row, Y]
    lean, narrowing, square = _outline(mxx, mxy, myy)
    nearest = depth - rows[row, EZ]
    for line in range(
        ti.max(ti.cast(ti.ceil(y - rows[row, EY]), ti.i32), top),
        ti.min(ti.cast(ti.floor(y + rows[row, EY]), ti.i32) + 1, bottom),
    ):
        dy = line - y
        left, right = _span(x, dy, lean, narrowing, square, packs)
        for pack in range(left, right + 1):
            cell = (line - top) * packs + pack
            if nearest < farthest[worker, cell]:
                dx = _beside(x, pack)
                least = dx * (mxx * dx + mxy * dy) + myy * dy * dy
                middle = depth + hx * dx + hy * dy
                met = least < radius
                front = middle - ti.sqrt(ti.max(radius - least, 0.0) / c)
                own, near = cells[worker, cell, OWN], cells[worker, cell, NEAR]
                found = ti.select(met, front, ti.select(least < lowest, middle, FAR))
                own = ti.select(met, ti.min(own, front), own)
                cells[worker, cell, OWN] = own
                cells[worker, cell, NEAR] = ti.min(near, found)
                visits[worker, cell] = visits[worker, cell] + 1
                if visits[worker, cell] % PATIENCE == 0:
                    farthest[worker, cell] = farthest_of(own)
                    limits[worker, pack] = limit_of(pack, packs, bottom - top, worker, farthest)


@ti.func
def gather(
    row, rows: ti.template(), top, bottom, packs, worker, cells: ti.template(), farthest: ti.template(), whole
):  # fmt: skip
    """Add a blob's density where rays are, and its derivatives; if `whole`, gradients and tints too."""
    depth, c, hx, hy = rows[row, DEPTH], rows[row, C], rows[row, HX], rows[row, HY]
    mxx, mxy, myy = rows[row, MXX], rows[row, MXY], rows[row, MYY]
    x, y = rows[row, X], rows[row, Y]
    lean, narrowing, square = _outline(mxx, mxy, myy)
    nearest = depth - rows[row, EZ]
    for line in range(
        ti.max(ti.cast(ti.ceil(y - rows[row, EY]), ti.i32), top),
        ti.min(ti.cast(ti.floor(y + rows[row, EY]), ti.i32) + 1, bottom),
    ):
        dy = line - y
        left, right = _span(x, dy, lean, narrowing, square, packs)
        for pack in range(left, right + 1):
            cell = (line - top) * packs + pack
            if nearest < farthest[worker, cell]:
                dx = _beside(x, pack)
                below = cells[worker, cell, NEAR] - (depth + hx * dx + hy * dy)
                slope = c * below
                rest = ti.max(1.0 - dx * (mxx * dx + mxy * dy) - myy * dy * dy - slope * below, 0.0)
                twice = rest * rest
                sixth = twice * twice * twice
                seventh = sixth * rest
                density = seventh * rest
                cells[worker, cell, F] = cells[worker, cell, F] + density
                cells[worker, cell, SLOPE] = cells[worker, cell, SLOPE] - 16.0 * seventh * slope
                bend = sixth * (224.0 * slope * slope) - seventh * (16.0 * c)
                cells[worker, cell, BEND] = cells[worker, cell, BEND] + bend
                if whole:
                    across = 2.0 * mxx * dx + mxy * dy - 2.0 * hx * slope
                    down = 2.0 * myy * dy + mxy * dx - 2.0 * hy * slope
                    cells[worker, cell, ACROSS] = cells[worker, cell, ACROSS] + seventh * across
                    cells[worker, cell, DOWN] = cells[worker, cell, DOWN] + seventh * down
                    for kept, number in ti.static(((SHARES, SHARE), (REDS, RED), (GREENS, GREEN), (BLUES, BLUE))):
                        cells[worker, cell, kept] = cells[worker, cell, kept] + density * rows[row, number]


@ti.func
def solve(density, slope, bend, level):
    """How much farther the surface G = `level` is, m; by how much G exceeds it at most; G/(8 F); and −G'', 1/m².

    Of the parabola through G with its derivatives the nearer crossing is taken.
    """
    safe = ti.max(density, 1e-20)
    g = ti.sqrt(ti.sqrt(ti.sqrt(safe)))
    ratio = 0.125 * g / safe
    g1 = ratio * slope
    g2 = ratio * (bend - 0.875 * slope * slope / safe)
    g2 = ti.min(g2, -0.05 * g1 * g1 / g - 1e-12)
    square = g1 * g1 - 2.0 * g2 * (g - level)
    step = (ti.sqrt(ti.max(square, 0.0)) - g1) / g2
    return step, -0.5 * square / g2, ratio, -g2


@ti.func
def climb(worker, cell, cells: ti.template(), level, last):
    """Step towards the surface, which is not behind the first blob that a ray meets for itself.

    Rays that miss it, and in the `last` step those that are still far off, go on at that blob. Returns whether there
    are rays that missed it or were far off.
    """
    near, own = cells[worker, cell, NEAR], cells[worker, cell, OWN]
    step, over, _, bend = solve(cells[worker, cell, F], cells[worker, cell, SLOPE], cells[worker, cell, BEND], level)
    there, behind = near < 0.5 * FAR, own < 0.5 * FAR
    hit = there & (over > 0.0)
    long = hit & (step * step * bend > LONG * LONG)
    missed = there & (over <= 0.0) & behind & (own > near)
    again = missed | (long & behind & last)
    cells[worker, cell, NEAR] = ti.select(again, own, ti.select(hit, ti.min(near + step, own), FAR))
    doubtful = missed | long
    marked = 0
    for i in ti.static(range(PACK)):
        marked |= doubtful[i]
    return marked
